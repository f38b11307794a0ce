"""The calibration report: one HTML page that an engineer reads, prints and signs.

It is drawn from what is kept of a calibration (calibration.json, points.csv, the sources), so it
can be drawn again at any later time, with the same figures.  Who draws it elsewhere takes the
evidence from here: what was seen in each picture, and which pictures disagree most.  Other pages
that are files take their elements from here, and the round numbers along axes.
"""

from station.report.drawing import ticks
from station.report.evidence import (
    PictureEvidence,
    PointSet,
    evidence_of,
    whitened_dots,
    whitened_stripe,
)
from station.report.markup import Child, Markup, element, join
from station.report.page import calibration_report
from station.report.ranking import RankedPicture, Solved, worst_first
from station.report.wording import count, minus

__all__ = [
    "Child",
    "Markup",
    "PictureEvidence",
    "PointSet",
    "RankedPicture",
    "Solved",
    "calibration_report",
    "count",
    "element",
    "evidence_of",
    "join",
    "minus",
    "ticks",
    "whitened_dots",
    "whitened_stripe",
    "worst_first",
]
