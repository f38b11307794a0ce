"""Where to show the target next: the pose that leaves least open of the sheet."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from calib.arrays import FloatArray
from calib.planning.doubt import SheetDoubt, information_of
from calib.planning.field import Coverage
from calib.planning.imagined import Scatter, imagined_view
from calib.planning.standing import Standing, pose_of
from calib.target import Target

_TILTS_DEG = (0.0, 25.0)
"""More shows the focal length better, but dots seen so obliquely are located worse."""
_NEAR_EDGES_DEG = (0.0, 90.0, 180.0, 270.0)
_PLACES = 5
"""Along each side of the field."""


@dataclass(frozen=True, slots=True)
class NextPose:
    """How to hold the target, and what that is worth.

    Attributes
    ----------
    standing
        Where and how.
    centre_px
        Where in the picture its middle is then seen.
    sigma_mm
        What the sheet's RMS standard deviation over the field then falls to.
    """

    standing: Standing
    centre_px: tuple[float, float]
    sigma_mm: float


def next_pose(
    doubt: SheetDoubt, target: Target, scatter: Scatter, coverage: Coverage | None = None
) -> NextPose | None:
    """Return the pose that is worth most.

    Parameters
    ----------
    doubt
        What the pictures so far leave open.
    scatter
        How their points scatter.
    coverage
        Where given, poses that show dots in cells without any come first, those with most of them.

    Returns
    -------
    NextPose
        None where no pose shows the whole target crossed by the stripe.

    Notes
    -----
    The best of a few hundred poses whose middle lies on the sheet, by the trace of the covariance
    over the field (A-optimal design).
    """
    best: tuple[int, float, NextPose] | None = None
    for standing in _standings(doubt):
        pose = pose_of(standing, target)
        view = imagined_view(doubt.sensor, target, pose, scatter)
        if view is None:
            continue
        sigma_mm = doubt.sigma_mm(information_of(view, target, doubt.sensor, pose))
        u, v = doubt.sensor.camera.project(np.array([standing.middle_in_cam_mm]))[0].tolist()
        found = NextPose(standing, (u, v), sigma_mm)
        size = {"width": doubt.sensor.camera.width, "height": doubt.sensor.camera.height}
        gain = 0 if coverage is None else coverage.gain(view.points.centre_px, **size)
        if best is None or (-gain, sigma_mm) < best[:2]:
            best = (-gain, sigma_mm, found)
    return None if best is None else best[2]


def _standings(doubt: SheetDoubt) -> Iterator[Standing]:
    for middle in _middles(doubt):
        x, y, z = middle.tolist()
        for tilt_deg in _TILTS_DEG:
            for near_deg in _NEAR_EDGES_DEG[: None if tilt_deg else 1]:
                yield Standing((x, y, z), tilt_deg, near_deg)


def _middles(doubt: SheetDoubt) -> FloatArray:
    """Return places on the sheet, shape (N, 3), spread over the field."""
    low, high = doubt.pixels_px.min(axis=0), doubt.pixels_px.max(axis=0)
    parts = (np.arange(_PLACES) + 0.5) / _PLACES
    u, v = np.meshgrid(*(low + np.outer(parts, high - low)).T)
    places = doubt.sensor.locate(np.column_stack([u.ravel(), v.ravel()]))
    return np.asarray(places[np.isfinite(places).all(axis=1)])
