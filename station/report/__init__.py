"""The calibration report: one HTML page that an engineer reads, prints and signs.

It is drawn from what is kept of a calibration (calibration.json, points.csv, the sources), so it
can be drawn again at any later time, with the same figures.
"""

from station.report.page import calibration_report

__all__ = ["calibration_report"]
