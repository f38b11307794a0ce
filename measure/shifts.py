"""What a calibration makes of readings: the same stripe, read by it and by another one."""

from dataclasses import dataclass

import numpy as np

from calib import SENSOR_PARAMETERS, FloatArray, IntArray, Rig
from measure.mounting import Survey
from measure.quantities import OF_A_PROFILE, Quantity, Reading
from measure.reference import ReferenceProfile
from measure.shot import Shot
from measure.wheel import WheelReadings, measure_wheel_on_rig


@dataclass(frozen=True, slots=True, eq=False)
class Installation:
    """Sensors as they are calibrated, and what is known of the wheels that pass them."""

    rig: Rig
    survey: Survey


@dataclass(frozen=True, slots=True)
class Shift:
    """By how much a reading is another one with another calibration.

    Attributes
    ----------
    quantity
        Which reading.
    by_mm
        After minus before.
    u95_mm
        What both calibrations leave open of that, 95 %, taken as independent: it is smaller where
        they share pictures or a camera.
    """

    quantity: Quantity
    by_mm: float
    u95_mm: float

    @property
    def within(self) -> bool:
        """Whether it is no more than both calibrations leave open."""
        return abs(self.by_mm) <= self.u95_mm


@dataclass(frozen=True, slots=True)
class ReadingShifts:
    """The shifts of all that can be read with both; none with a reason where that is nothing."""

    shifts: tuple[Shift, ...]
    reason: str | None = None

    @property
    def within(self) -> bool:
        """Whether no reading shifts by more than both calibrations leave open."""
        return all(each.within for each in self.shifts)


def reading_shifts(
    shot: Shot,
    before: Installation,
    after: Installation,
    reference: ReferenceProfile,
    *,
    sensor: str,
) -> ReadingShifts:
    r"""Tell by how much the readings of a wheel shift when a sensor has another calibration.

    Parameters
    ----------
    shot
        What is read twice, see `relaid`.
    before, after
        The sensors with one calibration and with the other.
    reference
        The profile that wear is counted from.
    sensor
        Whose calibration is another one.

    Returns
    -------
    ReadingShifts

    Notes
    -----
    The pixels are the same, so their noise, the survey and the axle move both readings alike. What
    is left are the two calibrations: of a reading's variance the part that goes away where the
    sensor is known exactly, :math:`u_{95}^2(C) - u_{95}^2(C - C_{\cdot s} C_{ss}^{-1}
    C_{s \cdot})`.
    """
    found = [_read(shot, each, reference) for each in (before, after)]
    reason = next((each.reason for each in found if each.reason is not None), None)
    if reason is not None:
        return ReadingShifts((), reason)
    surer = [
        _read(shot, Installation(_known(each.rig, sensor), each.survey), reference)
        for each in (before, after)
    ]
    shifts = []
    for quantity in OF_A_PROFILE:
        (old, new), exact = ([each.readings[quantity] for each in pair] for pair in (found, surer))
        if old.value is not None and new.value is not None:
            u95 = np.hypot(_owed_mm(old, exact[0]), _owed_mm(new, exact[1]))
            shifts.append(Shift(quantity, new.value - old.value, float(u95)))
    return ReadingShifts(tuple(shifts))


def _read(shot: Shot, by: Installation, reference: ReferenceProfile) -> WheelReadings:
    return measure_wheel_on_rig([shot], by.rig, by.survey, reference)


def _owed_mm(reading: Reading, exact: Reading) -> float:
    """Return what a reading's u95 owes to a calibration, by its reading without the doubt of it."""
    u95, without = reading.u95 or 0.0, exact.u95 or 0.0
    # A merged profile may be a hair surer with one more doubt to put a difference down to.
    return float(np.sqrt(max(u95**2 - without**2, 0.0)))


def _known(rig: Rig, sensor: str) -> Rig:
    """Return a rig one of whose sensors is known exactly, and with it what follows it."""
    own = rig.columns(sensor)[: len(SENSOR_PARAMETERS)]
    covariance: FloatArray = rig.covariance - _told_by(rig.covariance, own)
    covariance[own] = covariance[:, own] = 0.0
    # Rounding may leave a variance that is all told a little negative.
    np.fill_diagonal(covariance, np.maximum(np.diag(covariance), 0.0))
    return Rig(rig.sensors, covariance)


def _told_by(covariance: FloatArray, own: IntArray) -> FloatArray:
    """Return the part of a covariance that goes with some of its parameters."""
    across = covariance[:, own]
    scale = np.sqrt(np.diag(covariance)[own])
    safe = np.where(scale > 0.0, scale, 1.0)
    # By correlations: focal lengths and distortions differ by ten orders.
    correlation = covariance[np.ix_(own, own)] / np.outer(safe, safe)
    information = np.linalg.pinv(correlation, rcond=1e-10, hermitian=True)
    return np.asarray(across / safe @ information @ (across / safe).T)
