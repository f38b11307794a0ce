"""The peer for solving: `vision-calibration`, a bundle adjustment of camera, poses and plane."""

from collections.abc import Sequence
from types import ModuleType
from typing import Any

import numpy as np

from calib import FloatArray, Target, View

MODULE = "vision_calibration"


def peer_plane(module: ModuleType, views: Sequence[View], target: Target) -> FloatArray:
    """Solve camera and light plane by the peer; return (a, b, c, d).

    Its camera cannot be held at known values, so the camera is estimated. Its default holds the
    first pose where Zhang's closed form put it; here every pose is free, which serves it better.

    Parameters
    ----------
    module
        The peer.
    views
        Each with a stripe; the peer weighs all points alike, as noise of one size wants it.
    target
        The target in the views.
    """
    config = module.LaserlineDeviceCalibrationConfig()
    config.optimize.fix_poses = []
    dataset = module.LaserlineDataset([_peer_view(module, view, target) for view in views])
    answer = module.run_laserline_device(dataset, config).estimate.params.plane
    coefficients = np.append(answer.normal_xyz, answer.distance)
    return np.asarray(coefficients if answer.distance >= 0.0 else -coefficients)


def _peer_view(module: ModuleType, view: View, target: Target) -> Any:
    if view.stripe is None:
        raise ValueError(f"{view.name}: the peer wants a stripe in every view")
    observation = module.Observation(
        view.points.points_mm(target.pitch_mm).tolist(), view.points.centre_px.tolist()
    )
    # It says weights are optional, and refuses their absence.
    return module.LaserlineView(
        observation, view.stripe.centre_px.tolist(), [1.0] * len(view.stripe)
    )
