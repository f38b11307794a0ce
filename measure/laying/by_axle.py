"""Stripes laid over the reference by the survey of the installation: which points, and where.

The sensors of a rig lay theirs together: they see one wheel on one axle.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib import Cause, FloatArray, IntArray, Rig, RigSensor
from measure.keeping.cleaning import Kept, keep_wheel
from measure.keeping.noise import Noise
from measure.laying.axle import Axle, solve_axle
from measure.laying.section import AxleMap, Section, SheetPoints, radial_place_mm
from measure.mounting import Survey
from measure.placing.flange import NARROWEST_RIM_MM, WHEELS_APART_MM, Voters, find_flanges
from measure.placing.registration import best_shift, refine_shift, tip_misfit_mm
from measure.placing.template import Template

MIN_WHEEL_POINTS = 60
# S1002 by LMA is off by 0.3: more is no flange, or none that the laser drew.
MOST_TIP_MISFIT_MM = 0.5
_MIN_TREAD_POINTS = 20
_TREAD_HALF_MM = 12.0
# Flanges farther apart than a gross error of the rig and this many sigmas of vibration are not one.
_SAME_FLANGE_MM = 2.0
_SAME_FLANGE_SIGMAS = 5.0
_OF_ONE_RADIUS_MM = 15.0


@dataclass(frozen=True, slots=True, eq=False)
class Unmeasured:
    """A picture that gives no reading, and why."""

    reason: str


@dataclass(frozen=True, slots=True, eq=False)
class Laid:
    """The points of one wheel on one sheet, in order, laid over the reference.

    Attributes
    ----------
    sensor
        Which sensor's.
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
        afresh in every picture and the same in all. The columns are the same of all sensors.
    by_vibration_mm
        Shape (N, 2) for each sensor by whose tread the axle was found, where there are several:
        what the points do where that sensor has moved by one sigma along the radius.
    tread
        Where the sheet meets the tape circle; None where that hides, or no axle is known.
    axle
        By which it was laid; None where none is known.
    axle_offset_mm, sheet_yaw_rad
        How oblique the cut is; None where the axle is not known.
    """

    sensor: RigSensor
    sheet: SheetPoints
    section: Section
    shift_mm: FloatArray
    along_mm: FloatArray
    noise: Noise
    left_out: Mapping[Cause, int]
    once_mm: FloatArray
    shared_mm: FloatArray
    by_vibration_mm: Mapping[str, FloatArray]
    tread: "TreadSpot | None"
    axle: Axle | None
    axle_offset_mm: float | None
    sheet_yaw_rad: float | None

    def select(self, index: IntArray) -> "Laid":
        """Return the points that a rising index array picks; the rest is left out as glare."""
        dropped = len(self.along_mm) - len(index)
        glare = self.left_out.get(Cause.GLARE, 0) + dropped
        tread = self.tread
        if tread is not None:
            at = np.searchsorted(index, tread.index)
            there = np.isin(tread.index, index)
            tread = replace(tread, index=at) if there.all() else None
        return replace(
            self,
            sheet=self.sheet.select(index),
            section=self.section.select(index),
            along_mm=self.along_mm[index],
            noise=replace(self.noise, sigma_mm=self.noise.sigma_mm[index]),
            left_out={**self.left_out, Cause.GLARE: glare},
            once_mm=self.once_mm[index],
            shared_mm=self.shared_mm[index],
            by_vibration_mm={name: each[index] for name, each in self.by_vibration_mm.items()},
            tread=tread,
        )


@dataclass(frozen=True, slots=True, eq=False)
class Laying:
    """The stripes of one shot on the reference.

    Attributes
    ----------
    parts
        Of each sensor that shows the wheel; the first is the one that shows most of it.
    silent
        Why the others show nothing, by name.
    """

    parts: tuple[Laid, ...]
    silent: Mapping[str, str]


@dataclass(frozen=True, slots=True, eq=False)
class TreadSpot:
    """Where a sheet meets the tape circle: a weighted mean of points near it.

    Attributes
    ----------
    in_rig_mm, outward
        Shape (2,), (x, z): the place, and the direction from the axle to it.
    index, weight
        Shape (K,): which points of the sheet, and their share in the mean.
    """

    in_rig_mm: FloatArray
    outward: FloatArray
    index: IntArray
    weight: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """A wheel on one sheet, laid by a guess of the axle."""

    sensor: RigSensor
    sheet: SheetPoints
    section: Section
    shift_mm: FloatArray
    kept: Kept
    tread: TreadSpot | None


def lay_by_axle(
    sheets: Mapping[str, SheetPoints], rig: Rig, survey: Survey, template: Template
) -> Laying | Unmeasured:
    """Lay stripes over the reference with the survey's directions and the axle they show.

    Parameters
    ----------
    sheets
        The points of each sensor that took a picture, by name; one or more.
    rig
        Where the sensors stand.
    survey
        What is known of the wheels that pass.
    template
        The reference.
    """
    radial_x = float(
        np.mean([
            radial_place_mm(rig[name], survey, sheet.points_in_cam_mm)
            for name, sheet in sheets.items()
        ])
    )
    guess = Axle.exact(radial_x, survey.wheel_radius_mm)
    tried = {name: _find(rig[name], sheet, guess, template) for name, sheet in sheets.items()}
    found = [each for each in tried.values() if isinstance(each, _Found)]
    silent = {name: each.reason for name, each in tried.items() if isinstance(each, Unmeasured)}
    if not found:
        fullest = max(sheets, key=lambda name: len(sheets[name]))
        return Unmeasured(silent[fullest])
    laid = _together(found, survey, radial_x, template)
    agreeing = [part for part in laid if _apart_mm(part, laid[0]) <= _reach_mm(survey)]
    if len(agreeing) < len(laid):
        names = {part.sensor.name for part in agreeing}
        first = [each for each in found if each.sensor.name in names]
        others = {n: sheets[n] for n in (each.sensor.name for each in found) if n not in names}
        laid = _looked_for_again(first, others, rig, survey, radial_x, template)
        for part in laid[1:]:
            if (apart := _apart_mm(part, laid[0])) > _reach_mm(survey):
                silent[part.sensor.name] = _why_apart(part, laid[0], apart, survey)
        laid = [part for part in laid if part.sensor.name not in silent]
    if not laid:
        return Unmeasured(
            "half a wheel: the tread at the tape circle is not seen; look at the field of view, "
            "and for glare"
        )
    return Laying(tuple(laid), silent)


def _together(
    found: Sequence[_Found], survey: Survey, radial_x: float, template: Template
) -> list[Laid]:
    """Lay all by the axle that their treads show, what shows most first; none without a tread."""
    treads = {w.sensor.name: w.tread.in_rig_mm for w in found if w.tread is not None}
    if not treads:
        return []
    # Once: which points lie beside the tape circle is lateral, and no axle changes that.
    axle = solve_axle(np.array(list(treads.values())), survey, radial_x)
    laid = [_laid(wheel, axle, list(treads), survey, template) for wheel in found]
    return sorted(laid, key=lambda part: -len(np.unique(np.floor(part.along_mm))))


def _looked_for_again(
    first: Sequence[_Found],
    sheets: Mapping[str, SheetPoints],
    rig: Rig,
    survey: Survey,
    radial_x: float,
    template: Template,
) -> list[Laid]:
    """Lay the first ones, and what other sheets show where these have seen the flange.

    In bad light a sheet may hold something else that is more like a flange.
    """
    laid = _together(first, survey, radial_x, template)
    axle = laid[0].axle if laid else None
    if axle is None:
        return []
    found = list(first)
    for name, sheet in sheets.items():
        again = _find(rig[name], sheet, axle, template, shift_mm=laid[0].shift_mm)
        if isinstance(again, _Found):
            found.append(again)
    return _together(found, survey, radial_x, template)


def _reach_mm(survey: Survey) -> float:
    return _SAME_FLANGE_MM + _SAME_FLANGE_SIGMAS * survey.sigma_vibration_mm


def _apart_mm(one: Laid, other: Laid) -> float:
    return float(np.hypot(*(one.shift_mm - other.shift_mm)))


def _why_apart(part: Laid, first: Laid, apart_mm: float, survey: Survey) -> str:
    return (
        f"its flange is {apart_mm:.1f} mm from where sensor {first.sensor.name} sees it, "
        f"{_reach_mm(survey):.1f} at most: check the rig, and that both were triggered together"
    )


def _find(
    sensor: RigSensor,
    sheet: SheetPoints,
    guess: Axle,
    template: Template,
    *,
    shift_mm: FloatArray | None = None,
) -> _Found | Unmeasured:
    """Find the wheel on a sheet: where its flange is, or where it is known to be."""
    section_map = guess.map(sensor.rig_from_camera)
    section = Section.of(sheet, section_map)
    shift = place_of_flange(section, sheet, template) if shift_mm is None else shift_mm
    if isinstance(shift, Unmeasured):
        return shift
    kept = keep(section, sheet, shift, template)
    if isinstance(kept, Unmeasured):
        return kept
    wheel = sheet.select(kept.index).unbent(sensor.sensor)
    section = Section.of(wheel, section_map)
    outward = section_map.outward_in_rig(wheel.points_in_cam_mm)[:, [0, 2]]
    tread = _tread_in_rig(sensor, wheel, section, shift, outward)
    return _Found(sensor, wheel, section, shift, kept, tread)


def _laid(found: _Found, axle: Axle, by: Sequence[str], survey: Survey, template: Template) -> Laid:
    """Lay a wheel again, by the axle itself, which some sensors' treads have shown."""
    section_map = axle.map(found.sensor.rig_from_camera)
    section = Section.of(found.sheet, section_map)
    # A new axle moves all radii at once, by far more than a refinement reaches.
    moved = np.median(section.points_mm - found.section.points_mm, axis=0)
    shift = refine_shift(section.points_mm, found.shift_mm + moved, template)
    outward = section_map.outward_in_rig(found.sheet.points_in_cam_mm)[:, [0, 2]]
    vibrations = _radially(-outward @ axle.by_vibration_mm)
    tilts = _tilt_motions(outward, section.points_mm - shift, survey)
    offset, yaw = _obliqueness(found.sensor, section_map, found.sheet)
    return Laid(
        sensor=found.sensor,
        sheet=found.sheet,
        section=section,
        shift_mm=shift,
        along_mm=found.kept.along_mm,
        noise=found.kept.noise,
        left_out=found.kept.left_out,
        once_mm=_radially(-outward @ axle.by_place_mm[:, None]),
        shared_mm=np.concatenate([_held(outward, axle), tilts], axis=2),
        by_vibration_mm=dict(zip(by, np.moveaxis(vibrations, 2, 0), strict=False)),
        tread=found.tread,
        axle=axle,
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
    aside = np.array([flange.shift_mm - flanges[0].shift_mm for flange in flanges])
    # Wheels of one axle are of one radius: what is like a flange lower down is the rim's edge.
    apart = float(np.abs(aside[np.abs(aside[:, 1]) < _OF_ONE_RADIUS_MM, 0]).max())
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
    sensor: RigSensor,
    wheel: SheetPoints,
    section: Section,
    shift_mm: FloatArray,
    outward: FloatArray,
) -> TreadSpot | None:
    """Return where in the rig the sheet meets the tape circle, or None if that hides."""
    y = section.points_mm[:, 0] - shift_mm[0]
    near = np.flatnonzero(np.abs(y) < _TREAD_HALF_MM)
    if len(near) < _MIN_TREAD_POINTS or not (y[near].min() < 0.0 < y[near].max()):
        return None
    # The constant of a parabola through the points is a weighted sum of them. A straight line would
    # lie 0.08 mm above the hollow of an S1002 tread, and a diameter be 0.15 mm too great.
    certainty = 1.0 / section.sigma_mm[near] ** 2
    design = y[near, None] ** np.arange(3)
    weight = np.linalg.solve((design.T * certainty) @ design, design.T * certainty)[0]
    in_rig = sensor.rig_from_camera.apply(wheel.points_in_cam_mm[near])
    return TreadSpot(weight @ in_rig[:, [0, 2]], weight @ outward[near], near, weight)


def _held(outward: FloatArray, axle: Axle) -> FloatArray:
    """Return what doubt of the axle lets the points do alike in all pictures.

    Over the 0.1 s that a wheel is in view its radius, the rail and the load on it stay as they are.
    """
    return _radially(-outward @ np.column_stack([axle.by_radius_mm, axle.by_height_mm]))


def _radially(motion_mm: FloatArray) -> FloatArray:
    """Return motions of r, shape (N, K), as motions of (a, r), shape (N, 2, K)."""
    return np.stack([np.zeros_like(motion_mm), motion_mm], axis=1)


def _tilt_motions(outward: FloatArray, places_mm: FloatArray, survey: Survey) -> FloatArray:
    """Turn the section about the tape circle, as an axle that is not along rig y does."""
    y, z = places_mm.T
    tilts = outward * survey.sigma_axle_direction_rad
    return np.stack([z[:, None] * tilts, -y[:, None] * tilts], axis=1)


def _obliqueness(
    sensor: RigSensor, section_map: AxleMap, sheet: SheetPoints
) -> tuple[float, float]:
    normal = sensor.rig_from_camera.rotation @ sensor.sensor.plane.normal_in_cam
    middle = np.median(sensor.rig_from_camera.apply(sheet.points_in_cam_mm), axis=0)
    axle = np.array([section_map.axle_x_mm, middle[1], section_map.axle_z_mm])
    return abs(float(normal @ (axle - middle))), float(np.arcsin(abs(normal[1])))
