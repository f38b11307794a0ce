"""A stripe laid over the reference by the survey of the installation: which points, and where."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from calib import Cause, FloatArray, LaserSensor
from measure.keeping.cleaning import Kept, keep_wheel
from measure.keeping.noise import Noise
from measure.laying.axle import Axle, solve_axle
from measure.laying.section import AxleMap, Section, SheetPoints, radial_place_mm
from measure.mounting import Mounting
from measure.placing.flange import NARROWEST_RIM_MM, WHEELS_APART_MM, Voters, find_flanges
from measure.placing.registration import best_shift, refine_shift, tip_misfit_mm
from measure.placing.template import Template

MIN_WHEEL_POINTS = 60
# S1002 by LMA is off by 0.3: more is no flange, or none that the laser drew.
MOST_TIP_MISFIT_MM = 0.5
_MIN_TREAD_POINTS = 20
_TREAD_HALF_MM = 12.0


@dataclass(frozen=True, slots=True, eq=False)
class Unmeasured:
    """A picture that gives no reading, and why."""

    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class Laid:
    """The points of one wheel, in order, laid over the reference.

    Attributes
    ----------
    sheet, section
        The points kept, from the flange back to the field side.
    shift_mm
        (y, z) of the reference = (a, r) - shift.
    along_mm
        Shape (N,), place along the reference.
    noise
        How the points scatter.
    left_out
        How many points of the picture were left out for which cause.
    once_mm, shared_mm
        Shape (N, 2, P), (N, 2, Q): what the installation lets the points do, one sigma each,
        afresh in every picture and the same in all.
    axle_offset_mm, sheet_yaw_rad
        How oblique the cut is; None where the axle is not known.
    """

    sheet: SheetPoints
    section: Section
    shift_mm: FloatArray
    along_mm: FloatArray
    noise: Noise
    left_out: Mapping[Cause, int]
    once_mm: FloatArray
    shared_mm: FloatArray
    axle_offset_mm: float | None
    sheet_yaw_rad: float | None


def lay_by_axle(
    sheet: SheetPoints, sensor: LaserSensor, mounting: Mounting, template: Template
) -> Laid | Unmeasured:
    """Lay a stripe over the reference with the survey's directions and the axle it shows."""
    radial_x = radial_place_mm(sensor, mounting, sheet.points_in_cam_mm)
    axle = Axle.exact(radial_x, mounting.wheel_radius_mm)
    section = Section.of(sheet, axle.map(mounting))
    shift = place_of_flange(section, sheet, template)
    if isinstance(shift, Unmeasured):
        return shift
    kept = keep(section, sheet, shift, template)
    if isinstance(kept, Unmeasured):
        return kept
    wheel = sheet.select(kept.index).unbent(sensor)
    section = Section.of(wheel, axle.map(mounting))
    tread = _tread_in_rig(wheel, section, shift, mounting)
    if tread is None:
        return Unmeasured(
            "half a wheel: the tread at the tape circle is not seen; look at the field of view, "
            "and for glare"
        )
    # Once: which points lie beside the tape circle is lateral, and no axle changes that.
    axle = solve_axle(tread, mounting, radial_x)
    before, section = section, Section.of(wheel, axle.map(mounting))
    # A new axle moves all radii at once, by far more than a refinement reaches.
    moved = np.median(section.points_mm - before.points_mm, axis=0)
    shift = refine_shift(section.points_mm, shift + moved, template)
    section_map = axle.map(mounting)
    outward = section_map.outward_in_rig(wheel.points_in_cam_mm)[:, [0, 2]]
    once, held = _axle_motions(outward, axle)
    tilts = _tilt_motions(outward, section.points_mm - shift, mounting)
    offset, yaw = _obliqueness(sensor, section_map, wheel)
    return Laid(
        sheet=wheel,
        section=section,
        shift_mm=shift,
        along_mm=kept.along_mm,
        noise=kept.noise,
        left_out=kept.left_out,
        once_mm=once,
        shared_mm=np.concatenate([held, tilts], axis=2),
        axle_offset_mm=offset,
        sheet_yaw_rad=yaw,
    )


def place_of_flange(
    section: Section, sheet: SheetPoints, template: Template
) -> FloatArray | Unmeasured:
    """Return the shift that lays a section's one flange over the reference.

    A sheet that is reflected draws the wheel a second time. Laid out by the true sheet, its
    section is out of shape: of several flanges of one wheel the one that fits best is taken.
    """
    voters = Voters(section.points_mm, section.tangent, section.to_camera)
    flanges = find_flanges(voters, template)
    if not flanges:
        return Unmeasured(
            f"no wheel: nothing like a flange among {len(section.points_mm)} stripe points"
        )
    apart = max(abs(flange.shift_mm[0] - flanges[0].shift_mm[0]) for flange in flanges)
    if WHEELS_APART_MM < apart < NARROWEST_RIM_MM:
        return Unmeasured(
            f"no wheel: two shapes like a flange {apart:.0f} mm apart; a rim is wider than that"
        )
    if apart >= NARROWEST_RIM_MM:
        return Unmeasured(
            f"two wheels: flanges {apart:.0f} mm apart in one picture; one is allowed"
        )
    shifts = [flange.shift_mm for flange in flanges]
    return best_shift(section.points_mm, sheet.stripe, shifts, template)


def keep(
    section: Section, sheet: SheetPoints, shift_mm: FloatArray, template: Template
) -> Kept | Unmeasured:
    """Return the points that are the wheel."""
    kept = keep_wheel(section.points_mm - shift_mm, section.sigma_mm, sheet.stripe, template)
    if len(kept.index) < MIN_WHEEL_POINTS:
        return Unmeasured(
            f"no wheel: {len(kept.index)} of {len(sheet)} stripe points make a profile, "
            f"{MIN_WHEEL_POINTS} needed"
        )
    return kept


def out_of_form(section: Section, shift_mm: FloatArray, template: Template) -> Unmeasured | None:
    """Tell whether a laid section has no flange's form, or None where it has."""
    misfit_mm = tip_misfit_mm(section.points_mm - shift_mm, template)
    if misfit_mm <= MOST_TIP_MISFIT_MM:
        return None
    return Unmeasured(
        f"no wheel: the flange's tip is {misfit_mm:.1f} mm off the reference's form, "
        f"{MOST_TIP_MISFIT_MM} at most; look for light that is not the laser's, or give the "
        "reference of this wheel"
    )


def _tread_in_rig(
    wheel: SheetPoints, section: Section, shift_mm: FloatArray, mounting: Mounting
) -> FloatArray | None:
    """Return (x, z) in the rig where the sheet meets the tape circle, or None if that hides."""
    y = section.points_mm[:, 0] - shift_mm[0]
    near = np.abs(y) < _TREAD_HALF_MM
    if near.sum() < _MIN_TREAD_POINTS or not (y[near].min() < 0.0 < y[near].max()):
        return None
    in_rig = mounting.rig_from_camera.apply(wheel.points_in_cam_mm[near])
    weight = 1.0 / section.sigma_mm[near]
    return np.array([np.polyfit(y[near], in_rig[:, axis], 1, w=weight)[1] for axis in (0, 2)])


def _axle_motions(outward: FloatArray, axle: Axle) -> tuple[FloatArray, FloatArray]:
    """Return what doubt of the axle lets the points do: afresh, and alike in all pictures.

    Over the 0.1 s that a wheel is in view its radius, the rail and the load on it stay as they are.
    """
    afresh = -outward @ axle.by_place_mm[:, None]
    alike = -outward @ np.column_stack([axle.by_radius_mm, axle.by_height_mm])
    return _radially(afresh), _radially(alike)


def _radially(motion_mm: FloatArray) -> FloatArray:
    """Return motions of r, shape (N, K), as motions of (a, r), shape (N, 2, K)."""
    return np.stack([np.zeros_like(motion_mm), motion_mm], axis=1)


def _tilt_motions(outward: FloatArray, places_mm: FloatArray, mounting: Mounting) -> FloatArray:
    """Turn the section about the tape circle, as an axle that is not along rig y does."""
    y, z = places_mm.T
    tilts = outward * mounting.sigma_axle_direction_rad
    return np.stack([z[:, None] * tilts, -y[:, None] * tilts], axis=1)


def _obliqueness(
    sensor: LaserSensor, section_map: AxleMap, sheet: SheetPoints
) -> tuple[float, float]:
    normal = section_map.rig_from_camera.rotation @ sensor.plane.normal_in_cam
    middle = np.median(section_map.rig_from_camera.apply(sheet.points_in_cam_mm), axis=0)
    axle = np.array([section_map.axle_x_mm, middle[1], section_map.axle_z_mm])
    return abs(float(normal @ (axle - middle))), float(np.arcsin(abs(normal[1])))
