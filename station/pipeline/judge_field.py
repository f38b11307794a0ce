"""The part of the picture in which calibrations were made, and are compared."""

from collections.abc import Sequence

import numpy as np

from calib import CalibError, FloatArray, RigidTransform, Target, pixel_grid
from station.documents import CalibrationDocument

MAP_STEP_PX = 32
_LEAST_PART = 0.02


def working_pixels(documents: Sequence[CalibrationDocument]) -> FloatArray:
    """Return pixels whose point on the sheet lies no nearer or farther than the targets did.

    Parameters
    ----------
    documents
        Calibrations of one camera; the working volume is what any of them has seen.

    Returns
    -------
    pixels_px
        Shape (N, 2), on a grid of `MAP_STEP_PX`: the whole picture where the calibrations do not
        tell their targets, or hardly any pixel lies within.
    """
    sensor = documents[0].laser_sensor()
    pixels = pixel_grid(sensor.camera.width, sensor.camera.height, MAP_STEP_PX)
    depths = np.concatenate([np.empty(0), *(_depths_mm(document) for document in documents)])
    if len(depths) == 0:
        return pixels
    depth = sensor.locate(pixels)[:, 2]
    inside = (depth >= depths.min()) & (depth <= depths.max())
    return np.asarray(pixels[inside]) if inside.mean() > _LEAST_PART else pixels


def _depths_mm(document: CalibrationDocument) -> FloatArray:
    """Return depths of the target's points in all poses; none where the target is not told."""
    try:
        points = Target.parse(str(document.options.get("target", ""))).points_mm
    except CalibError:
        return np.empty(0)
    poses = [
        RigidTransform.from_rotation_vector(pose.rotation_vector, pose.translation_mm)
        for pose in document.poses
    ]
    return np.concatenate([np.empty(0), *(pose.apply(points)[:, 2] for pose in poses)])
