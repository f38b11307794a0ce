"""The gates a calibration must pass before it measures wheels."""

import numpy as np

from calib import Calibration
from station.documents import Gate

FEWEST_VIEWS = 3.0
"""Three poses fix a plane with nothing to check it by; below, it is not fixed at all."""

LARGEST_SIGMA_SCALE = 3.0
"""Residuals more than three times their predicted size: the model or the pictures are wrong."""

LARGEST_SHEET_SIGMA_MM = 0.05
"""Half of what a type-4 wheel gauge is trusted with (0.1 mm, two standard deviations)."""


def gates(answer: Calibration) -> dict[str, Gate]:
    """Return every gate with its figure."""
    used = sum(view.cam_from_board is not None and not view.left_out for view in answer.views)
    return {
        "views_used": Gate(value=used, limit=FEWEST_VIEWS, passed=used >= FEWEST_VIEWS),
        "dots_sigma_scale": at_most(answer.solve.sigma_scale_dots, LARGEST_SIGMA_SCALE),
        "stripe_sigma_scale": at_most(answer.solve.sigma_scale_stripe, LARGEST_SIGMA_SCALE),
        "sheet_sigma_mm": at_most(_sheet_sigma_mm(answer), LARGEST_SHEET_SIGMA_MM),
    }


def at_most(value: float, limit: float) -> Gate:
    """Return the gate of a figure that must not be greater than its limit."""
    return Gate(value=value, limit=limit, passed=bool(value <= limit))


def _sheet_sigma_mm(answer: Calibration) -> float:
    """RMS over all stripe points seen of the calibration's own part of a point's sigma, mm."""
    pixels_px = np.vstack([
        view.stripe.centre_px for view in answer.seen if view.stripe is not None
    ])
    return float(np.sqrt(np.nanmean(answer.sensor.sigma_on_sheet(pixels_px) ** 2)))
