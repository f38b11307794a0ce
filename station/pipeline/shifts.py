"""What a new calibration would make of readings, told on a wheel that was measured before."""

from collections.abc import Sequence
from dataclasses import dataclass

from calib import BoolArray, Rig
from measure import Installation, Profile, ReadingShifts, reading_shifts, relaid
from station.documents import CalibrationDocument, ProfileDocument, RigDocument
from station.errors import StationError
from station.pipeline.references import load_reference
from station.pipeline.rig_gauge import RigGauge


@dataclass(frozen=True, slots=True)
class SeenBefore:
    """A wheel that was measured, and by what.

    Attributes
    ----------
    profile
        Its profile.
    back_mm
        Where its flange back stood, rig y.
    present
        The calibrations in force: of the sensor, or of all sensors of its rig.
    rig
        The rig's in force; None of a sensor by itself.
    reference
        What wear is counted from, by name or file.
    """

    profile: ProfileDocument
    back_mm: float
    present: tuple[CalibrationDocument, ...]
    rig: RigDocument | None
    reference: str


def shifts_with(new: CalibrationDocument, seen: SeenBefore) -> ReadingShifts:
    """Return by how much readings shift once a sensor's new calibration is in force.

    The wheel's profile is laid back into the pictures by what is in force, and read off them again
    by both: what pictures and survey leave open is the same in both.

    Parameters
    ----------
    new
        The calibration; its sensor has one among those in force.
    seen
        The wheel.

    Returns
    -------
    ReadingShifts
        None, with a reason, where the wheel cannot be read again.
    """
    later = tuple(new if each.sensor == new.sensor else each for each in seen.present)
    try:
        before, after = (_installed(each, seen) for each in (seen.present, later))
        reference = load_reference(seen.reference)
    except StationError as error:
        return ReadingShifts((), str(error))
    if before is None or after is None:
        return ReadingShifts((), f"sensor {new.sensor} has no mounting, which places wheels")
    parts = _parts(seen.profile, new.sensor)
    missing = [name for name in parts if name not in before.rig.names]
    if missing:
        return ReadingShifts((), f"the wheel was seen by {missing[0]}, which is no longer there")
    shot = relaid(parts, seen.back_mm, before.rig, before.survey)
    if shot is None:
        return ReadingShifts((), "the wheel's tread at the tape circle was not seen")
    return reading_shifts(shot, before, after, reference, sensor=new.sensor)


def _installed(
    calibrations: Sequence[CalibrationDocument], seen: SeenBefore
) -> Installation | None:
    """Return the sensors as they stand beside the track; None of one without a mounting."""
    if seen.rig is not None:
        gauge = RigGauge.of(seen.rig, seen.reference, calibrations=calibrations)
        return Installation(gauge.rig, gauge.survey)
    (calibration,) = calibrations
    if calibration.mounting is None:
        return None
    mounting = calibration.mounting.mounting()
    sensor = calibration.laser_sensor()
    return Installation(Rig.of_one(sensor, mounting.rig_from_camera, calibration.sensor), mounting)


def _parts(document: ProfileDocument, sensor: str) -> dict[str, Profile]:
    """Return what of a profile each sensor saw."""
    profile = document.profile()
    if profile.seen_by is None:
        return {sensor: profile}
    masks = {name: profile.seen_by >> bit & 1 == 1 for bit, name in enumerate(document.sensors)}
    return {name: _part(profile, mask) for name, mask in masks.items() if mask.any()}


def _part(profile: Profile, mask: BoolArray) -> Profile:
    return Profile(profile.d_mm[mask], profile.h_mm[mask], profile.sigma_mm[mask])
