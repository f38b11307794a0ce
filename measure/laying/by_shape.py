"""A stripe laid over the reference by its own shape, where no survey of the installation is known.

Which way the wheel lies in the sheet is found by trying, then refined on what does not wear; that
the result leans on the reference is said in every status. The cut is laid as a radial one: what it
may be instead is told by `measure.laying.shape_doubt`.
"""

from dataclasses import dataclass

import numpy as np

from calib import FloatArray, LaserSensor, RigSensor
from measure.laying.by_axle import (
    Laid,
    Laying,
    Unmeasured,
    keep,
    out_of_form,
    place_of_flange,
)
from measure.laying.section import Section, SheetMap, SheetPoints
from measure.laying.shape_doubt import ShapeDoubt
from measure.placing.flange import Voters, find_flanges
from measure.placing.template import Template

# Outward is towards the camera, or the tread would not be seen.
_ANGLES_RAD = np.radians(np.arange(-75.0, 75.1, 5.0))
_SEARCH_POINTS = 250
_BAND_MM = (-12.0, 4.0)
_MIN_FIT_SHARE = 0.3
_ROUNDS = 12
_NEAR_MM = 3.0
_HUBER_MM = 0.1
_PAST_TIP_MM = 2.0


@dataclass(frozen=True, slots=True)
class _Lie:
    """How the wheel lies in the sheet."""

    angle_rad: float
    mirrored: bool

    def map(self, sensor: LaserSensor) -> SheetMap:
        return SheetMap.in_plane(sensor.plane, self.angle_rad, mirrored=self.mirrored)


def lay_by_shape(sheet: SheetPoints, of: RigSensor, template: Template) -> Laying | Unmeasured:
    """Lay the stripe of one sensor over the reference by the shape of the flange."""
    sensor = of.sensor
    lie = _best_lie(sheet, sensor, template)
    if lie is None:
        return Unmeasured(
            f"no wheel: no way to turn {len(sheet)} stripe points lays them over the reference"
        )
    section = Section.of(sheet, lie.map(sensor))
    shift = place_of_flange(section, sheet, template)
    if isinstance(shift, Unmeasured):
        return shift
    lie, shift = _refined(sheet, sensor, lie, shift, template)
    section = Section.of(sheet, lie.map(sensor))
    # Again, now that the direction is exact: a second wheel shows only then.
    shift = place_of_flange(section, sheet, template)
    if isinstance(shift, Unmeasured):
        return shift
    kept = keep(section, sheet, shift, template)
    if isinstance(kept, Unmeasured):
        return kept
    wheel = sheet.select(kept.index).unbent(sensor)
    section = Section.of(wheel, lie.map(sensor))
    if (misshapen := out_of_form(section, shift, template)) is not None:
        return misshapen
    doubt = ShapeDoubt.of(section, shift, template)
    if doubt.refusal is not None:
        return Unmeasured(doubt.refusal)
    laid = Laid(
        sensor=of,
        sheet=wheel,
        section=section,
        shift_mm=shift,
        along_mm=kept.along_mm,
        noise=kept.noise,
        left_out=kept.left_out,
        once_mm=np.zeros((len(wheel), 2, 0)),
        shared_mm=doubt.motions_mm,
        by_vibration_mm={},
        tread=None,
        axle=None,
        axle_offset_mm=None,
        sheet_yaw_rad=None,
    )
    return Laying((laid,), {})


def _best_lie(sheet: SheetPoints, sensor: LaserSensor, template: Template) -> _Lie | None:
    """Try directions; the best lays most of the stripe on the reference, flange on flange."""
    few = sheet.select(np.arange(0, len(sheet), max(1, len(sheet) // _SEARCH_POINTS)))
    lies = [_Lie(float(angle), mirrored) for angle in _ANGLES_RAD for mirrored in (False, True)]
    shares = [_fit_share(Section.of(few, lie.map(sensor)), template) for lie in lies]
    best = int(np.argmax(shares))
    return lies[best] if shares[best] >= _MIN_FIT_SHARE else None


def _fit_share(section: Section, template: Template) -> float:
    """Return which share of the points can be the wheel when the flange is laid on flange."""
    flanges = find_flanges(Voters(section.points_mm, section.tangent, section.to_camera), template)
    if not flanges:
        return 0.0
    _, outside, nearest = template.place(section.points_mm - flanges[0].shift_mm)
    along = np.abs(np.sum(section.tangent * template.tangent[nearest], axis=1)) > np.cos(0.4)
    facing = np.sum(section.to_camera * template.outward[nearest], axis=1) > 0.0
    inside = (outside > _BAND_MM[0]) & (outside < _BAND_MM[1])
    return float((along & facing & inside).mean()) * flanges[0].share


def _refined(
    sheet: SheetPoints, sensor: LaserSensor, lie: _Lie, shift_mm: FloatArray, template: Template
) -> tuple[_Lie, FloatArray]:
    """Improve direction and shift on flange back and tip, which do not wear."""
    for _ in range(_ROUNDS):
        section = Section.of(sheet, lie.map(sensor))
        placed = section.points_mm - shift_mm
        along, outside, nearest = template.place(placed)
        unworn = along < template.along_mm[template.tip] + _PAST_TIP_MM
        facing = np.sum(section.to_camera * template.outward[nearest], axis=1) > 0.0
        use = unworn & facing & (np.abs(outside) < _NEAR_MM)
        if use.sum() < 3:
            break
        normal, error, spot = template.outward[nearest[use]], outside[use], placed[use]
        scale = max(_HUBER_MM, 1.5 * float(np.median(np.abs(error))))
        weight = np.minimum(1.0, scale / np.maximum(np.abs(error), 1e-12))
        # Turning by a small angle moves (y, z) by (-z, y), about the flange tip.
        arm = spot - template.points_mm[template.tip]
        turning = normal[:, 1] * arm[:, 0] - normal[:, 0] * arm[:, 1]
        design = np.column_stack([-normal, turning]) * np.sqrt(weight)[:, None]
        step, *_ = np.linalg.lstsq(design, -error * np.sqrt(weight), rcond=None)
        lie, shift_mm = _turned(lie, shift_mm, step, template)
    return lie, shift_mm


def _turned(
    lie: _Lie, shift_mm: FloatArray, step: FloatArray, template: Template
) -> tuple[_Lie, FloatArray]:
    """Turn the wheel about its flange tip and shift it."""
    turn = float(step[2])
    cos, sin = np.cos(turn), np.sin(turn)
    tip = template.points_mm[template.tip]
    turned_tip = np.array([[cos, -sin], [sin, cos]]) @ (shift_mm + tip)
    angle = lie.angle_rad + (-turn if lie.mirrored else turn)
    return _Lie(angle, lie.mirrored), turned_tip - tip + step[:2]
