"""A measured profile laid back into the pictures: where the stripe of such a wheel would run."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from calib import Cause, FloatArray, Rig, RigSensor, StripePoints
from measure.gauging.levels import TAPE_D_MM
from measure.laying.axle import Axle
from measure.laying.section import Section, SheetPoints, radial_place_mm
from measure.mounting import Survey
from measure.profile import Profile
from measure.shot import Shot, WheelFrame

_WIDEST_GAP_MM = 2.0
"""Between points that are farther apart nothing was seen."""
_NEAR_TAPE_MM = 12.0
_LONGEST_STEP_PX = 3.0
"""Points of a stripe hang together: where those of the profile do not, some go between."""
# What the light was like is not kept; whoever reads one stripe twice takes it alike twice. Thin:
# what the stripe's bends had drawn is off the profile already.
_WIDTH_PX, _PEAK = 0.4, 150.0


def relaid(parts: Mapping[str, Profile], back_mm: float, rig: Rig, survey: Survey) -> Shot | None:
    """Return the shot in which a rig would see a measured profile.

    The wheel is put where it was seen along the axle, and with its axle in the sheet (on the mean,
    of several): how far from it axles pass moves readings to second order only.

    Parameters
    ----------
    parts
        Of each sensor, what of the profile it saw, from the flange back to the field side.
    back_mm
        Rig y of the flange back.
    rig
        The sensors.
    survey
        Of the wheels that pass: their radius at the tape circle.

    Returns
    -------
    shot
        Its points scatter as the profile says; None where the tread at the tape circle was not
        seen, or no part of the wheel falls into a picture.
    """
    seen = np.concatenate([*(part.points_mm for part in parts.values()), np.empty((0, 2))])
    beside = np.abs(seen[:, 0] - TAPE_D_MM)
    if not (len(seen) and beside.min() <= _NEAR_TAPE_MM):
        return None
    tape_mm = float(seen[np.argmin(beside), 1])
    axle_x = float(np.mean([_radial_x(rig[name], survey) for name in parts]))
    axle = Axle.exact(axle_x, survey.wheel_radius_mm)
    frames = []
    for name, part in parts.items():
        radii = survey.wheel_radius_mm + part.h_mm - tape_mm
        wheel_mm = np.column_stack([part.d_mm + back_mm, radii])
        stripe = _stripe_of(part, _pixels(wheel_mm, axle, rig[name]), axle, rig[name])
        if len(stripe):
            frames.append(WheelFrame(stripe, frame=0, source="", sensor=name))
    return Shot(tuple(frames)) if frames else None


def _radial_x(sensor: RigSensor, survey: Survey) -> float:
    """Return the rig x of an axle in the sheet, beside the middle of the picture."""
    camera = sensor.sensor.camera
    middle_px = np.array([[camera.width, camera.height]]) / 2.0 - 0.5
    return radial_place_mm(sensor, survey, sensor.sensor.locate(middle_px))


def _pixels(wheel_mm: FloatArray, axle: Axle, sensor: RigSensor) -> FloatArray:
    """Return where a camera sees circles of the wheel, (a, r), meet its sheet; NaN where not.

    A sheet meets each circle twice; it is the meeting that more of the picture shows.
    """
    pose = sensor.rig_from_camera
    normal = pose.rotation @ sensor.sensor.plane.normal_in_cam
    offset = sensor.sensor.plane.offset_mm - normal @ pose.translation_mm
    along, radii = wheel_mm.T
    # normal @ (x, a, z) + offset = 0 on the circle (x, z) = axle + r (cos phi, sin phi).
    across = np.hypot(normal[0], normal[2])
    level = normal[0] * axle.x_mm + normal[1] * along + normal[2] * axle.z_mm + offset
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = np.arccos(-level / (radii * across))
    meetings = []
    for side in (-1.0, 1.0):
        phi = np.arctan2(normal[2], normal[0]) + side * reach
        x, z = axle.x_mm + radii * np.cos(phi), axle.z_mm + radii * np.sin(phi)
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


def _stripe_of(part: Profile, pixels_px: FloatArray, axle: Axle, sensor: RigSensor) -> StripePoints:
    """Return a stripe through the pixels of a profile, broken where nothing was seen."""
    apart_mm = np.linalg.norm(np.diff(part.points_mm, axis=0), axis=1)
    steps = np.linalg.norm(np.diff(pixels_px, axis=0), axis=1)
    piece = np.flatnonzero((apart_mm <= _WIDEST_GAP_MM) & (steps > 0.0))
    points_of_piece = np.ceil(steps[piece] / _LONGEST_STEP_PX).astype(np.int64)
    first = np.repeat(np.cumsum(points_of_piece) - points_of_piece, points_of_piece)
    share = np.arange(points_of_piece.sum()) - first
    points = np.repeat(points_of_piece, points_of_piece)
    at = np.repeat(piece, points_of_piece)
    way = pixels_px[at + 1] - pixels_px[at]
    stripe = _thin(
        pixels_px[at] + (share / points)[:, None] * way,
        way[:, ::-1] / steps[at, None] * [1.0, -1.0],
    )
    if not len(stripe):
        return stripe
    sheet = SheetPoints.of(stripe, sensor.sensor)
    mm_a_px = Section.of(sheet, axle.map(sensor.rig_from_camera)).sigma_mm
    # Points that go between others tell nothing new: together they count as one.
    return replace(stripe, sigma_px=part.sigma_mm[at] * np.sqrt(points) / mm_a_px)


def _thin(centre_px: FloatArray, normal: FloatArray) -> StripePoints:
    count = len(centre_px)
    return StripePoints(
        centre_px=centre_px,
        normal=normal,
        sigma_px=np.ones(count),
        width_px=np.full(count, _WIDTH_PX),
        peak=np.full(count, _PEAK),
        saturated=np.zeros(count, dtype=bool),
        cause=(Cause.NONE,) * count,
    )
