"""A measured profile laid back into the pictures: where the stripe of such a wheel would run."""

from collections.abc import Mapping

import numpy as np

from calib import Cause, FloatArray, Rig, RigSensor, StripePoints
from measure.gauging.levels import TAPE_D_MM
from measure.laying.section import radial_place_mm
from measure.mounting import Survey
from measure.shot import Shot, WheelFrame

_WIDEST_GAP_MM = 2.0
"""Between points that are farther apart nothing was seen."""
_NEAR_TAPE_MM = 12.0
# What the light was like is not kept; whoever reads the same stripe twice takes it alike twice.
_SIGMA_PX, _WIDTH_PX, _PEAK = 0.1, 2.0, 150.0


def relaid(
    points_mm: Mapping[str, FloatArray], back_mm: float, rig: Rig, survey: Survey
) -> Shot | None:
    """Return the shot in which a rig would see a measured profile.

    The wheel is put where it was seen along the axle, and with its axle in the sheet (on the mean,
    of several): how far from it axles pass moves readings to second order only.

    Parameters
    ----------
    points_mm
        Of each sensor that saw a part of the profile, shape (N, 2), (d, h) from the flange back to
        the field side.
    back_mm
        Rig y of the flange back.
    rig
        The sensors.
    survey
        Of the wheels that pass: their radius at the tape circle.

    Returns
    -------
    shot
        With a point a pixel along each stripe; None where the tread at the tape circle was not
        seen, or no part of the wheel falls into a picture.
    """
    seen = np.concatenate([*points_mm.values(), np.empty((0, 2))])
    beside = np.abs(seen[:, 0] - TAPE_D_MM)
    if not (len(seen) and beside.min() <= _NEAR_TAPE_MM):
        return None
    tape_mm = float(seen[np.argmin(beside), 1])
    axle_x = float(np.mean([_radial_x(rig[name], survey) for name in points_mm]))
    frames = []
    for name, points in points_mm.items():
        radii = survey.wheel_radius_mm + points[:, 1] - tape_mm
        wheel_mm = np.column_stack([points[:, 0] + back_mm, radii])
        axle = np.array([axle_x, survey.wheel_radius_mm])
        stripe = _stripe_of(_pixels(wheel_mm, axle, rig[name]), points)
        if len(stripe):
            frames.append(WheelFrame(stripe, frame=0, source="", sensor=name))
    return Shot(tuple(frames)) if frames else None


def _radial_x(sensor: RigSensor, survey: Survey) -> float:
    """Return the rig x of an axle in the sheet, beside the middle of the picture."""
    camera = sensor.sensor.camera
    middle_px = np.array([[camera.width, camera.height]]) / 2.0 - 0.5
    return radial_place_mm(sensor, survey, sensor.sensor.locate(middle_px))


def _pixels(wheel_mm: FloatArray, axle_mm: FloatArray, sensor: RigSensor) -> FloatArray:
    """Return where a camera sees circles of the wheel, (a, r), meet its sheet; NaN where not.

    A sheet meets each circle twice; it is the meeting that more of the picture shows.
    """
    pose = sensor.rig_from_camera
    normal = pose.rotation @ sensor.sensor.plane.normal_in_cam
    offset = sensor.sensor.plane.offset_mm - normal @ pose.translation_mm
    along, radii = wheel_mm.T
    # normal @ (x, a, z) + offset = 0 on the circle (x, z) = axle + r (cos phi, sin phi).
    across = np.hypot(normal[0], normal[2])
    level = normal[0] * axle_mm[0] + normal[1] * along + normal[2] * axle_mm[1] + offset
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = np.arccos(-level / (radii * across))
    meetings = []
    for side in (-1.0, 1.0):
        phi = np.arctan2(normal[2], normal[0]) + side * reach
        x, z = axle_mm[0] + radii * np.cos(phi), axle_mm[1] + radii * np.sin(phi)
        in_cam = pose.inverse().apply(np.column_stack([x, along, z]))
        meetings.append(_in_picture(in_cam, sensor))
    return max(meetings, key=lambda pixels: int(np.isfinite(pixels[:, 0]).sum()))


def _in_picture(points_in_cam_mm: FloatArray, sensor: RigSensor) -> FloatArray:
    camera = sensor.sensor.camera
    pixels = np.full((len(points_in_cam_mm), 2), np.nan)
    before = points_in_cam_mm[:, 2] > 0.0
    pixels[before] = camera.project(points_in_cam_mm[before])
    last = np.array([camera.width, camera.height]) - 1.0
    inside = np.asarray(((pixels >= 0.0) & (pixels <= last)).all(axis=1))
    return np.where(inside[:, None], pixels, np.nan)


def _stripe_of(pixels_px: FloatArray, points_mm: FloatArray) -> StripePoints:
    """Return a stripe through pixels, a point a pixel along it, broken where nothing was seen."""
    apart_mm = np.linalg.norm(np.diff(points_mm, axis=0), axis=1)
    steps = np.linalg.norm(np.diff(pixels_px, axis=0), axis=1)
    unbroken = (apart_mm <= _WIDEST_GAP_MM) & np.isfinite(steps)
    along = np.concatenate([[0.0], np.cumsum(np.where(unbroken, steps, 0.0))])
    starts = np.flatnonzero(unbroken)
    place = np.arange(0.0, along[-1])
    # The last piece that begins before a place; those that are broken have no length.
    piece = starts[np.searchsorted(along[starts], place, side="right") - 1]
    share = (place - along[piece]) / steps[piece]
    centres = pixels_px[piece] + share[:, None] * (pixels_px[piece + 1] - pixels_px[piece])
    way = (pixels_px[piece + 1] - pixels_px[piece]) / steps[piece, None]
    count = len(place)
    return StripePoints(
        centre_px=centres,
        normal=way[:, ::-1] * [1.0, -1.0],
        sigma_px=np.full(count, _SIGMA_PX),
        width_px=np.full(count, _WIDTH_PX),
        peak=np.full(count, _PEAK),
        saturated=np.zeros(count, dtype=bool),
        cause=(Cause.NONE,) * count,
    )
