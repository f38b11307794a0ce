"""The calibration report: one HTML page that an engineer reads, prints and signs.

It is drawn from what is kept of a calibration (calibration.json, points.csv, the sources), so it
can be drawn again at any later time, with the same figures.  Who draws it elsewhere takes the
evidence from here: what was seen in each picture, and which pictures disagree most.
"""

from station.report.evidence import (
    PictureEvidence,
    PointSet,
    evidence_of,
    whitened_dots,
    whitened_stripe,
)
from station.report.page import calibration_report
from station.report.ranking import RankedPicture, worst_first

__all__ = [
    "PictureEvidence",
    "PointSet",
    "RankedPicture",
    "calibration_report",
    "evidence_of",
    "whitened_dots",
    "whitened_stripe",
    "worst_first",
]
