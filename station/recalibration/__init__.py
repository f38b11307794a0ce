"""Calibrating a sensor anew: when it is due, what follows from it, who is asked.

The work itself, from pictures to figures, is the worker's.  A rig, whose sensors share one frame,
would be decided upon by the same rules: its `Difference` is that of its sensors' placings.
"""

from station.recalibration.decision import Action, Decision, Outcome, decide, largest_ratio
from station.recalibration.evidence import Difference, Evidence, NewCalibration, PieceFindings
from station.recalibration.schedule import Schedule, owed

__all__ = [
    "Action",
    "Decision",
    "Difference",
    "Evidence",
    "NewCalibration",
    "Outcome",
    "PieceFindings",
    "Schedule",
    "decide",
    "largest_ratio",
    "owed",
]
