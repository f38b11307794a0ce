"""Where a wheel stood when a shot was taken, off its merged profile."""

import numpy as np

from calib import FloatArray, Rig
from measure.gauging.curve import Found
from measure.gauging.uncertainty import Budget, root_of
from measure.laying.by_axle import Laid
from measure.merging.causes import motion_by_rig
from measure.merging.merged import Merged
from measure.mounting import Survey
from measure.place import TreadPoint, WheelPlace
from measure.quantities import Status


def place_of(
    time_ns: int | None, merged: Merged, back: Found, rig: Rig, survey: Survey | None
) -> WheelPlace:
    """Return where the wheel stood in the rig; without a survey that says nothing of a wheel.

    Parameters
    ----------
    time_ns
        When the shot was taken.
    merged
        The profile, and the sensors' parts of it.
    back
        The flange back in it.
    rig, survey
        The sensors, and what is known of the installation.
    """
    if survey is None:
        return WheelPlace(time_ns, None, None, ())
    seen = back.status is Status.OK
    return WheelPlace(
        time_ns=time_ns,
        back_mm=back.estimate.value if seen else None,
        back=_back_budget(merged, back, survey) if seen else None,
        treads=tuple(
            point
            for part in merged.parts
            if (point := _tread_point(part, merged, rig, survey)) is not None
        ),
        back_at_mm=_back_at_mm(merged, back) if seen else None,
    )


def _back_budget(merged: Merged, back: Found, survey: Survey) -> Budget:
    """Return what is not known of the flange back's place in the rig.

    The motions of one sensor by itself do not hold its vibration: no reading suffers from it, but
    the place does.
    """
    budget = merged.motions.budget(back.estimate, back.blind_mm)
    vibration = survey.sigma_vibration_mm / np.sqrt(2.0) if len(merged.parts) == 1 else 0.0
    return Budget(float(np.hypot(budget.single_mm, vibration)), budget.shared_mm)


def _back_at_mm(merged: Merged, back: Found) -> FloatArray:
    """Return rig (x, z) of the flange back, of the sensor that told most of it."""
    told = np.bincount(merged.part, np.abs(back.estimate.gradient[:, 0]))
    part = merged.parts[int(np.argmax(told))]
    nearest = int(np.argmin(np.abs(part.section.points_mm[:, 0] - back.estimate.value)))
    in_rig = part.sensor.rig_from_camera.apply(part.sheet.points_in_cam_mm[[nearest]])
    return np.asarray(in_rig[0, [0, 2]])


def _tread_point(part: Laid, merged: Merged, rig: Rig, survey: Survey) -> TreadPoint | None:
    """Return where a sheet meets the tape circle, as its sensor alone places it."""
    spot = part.tread
    if spot is None:
        return None
    by_sensor = spot.weight @ motion_by_rig(part)[spot.index, 1]
    by_rig = by_sensor @ root_of(rig.covariance)[rig.columns(part.sensor.name)]
    # The causes of the rig come first; doubt of the axle moves radii, but no place.
    radially = np.zeros(merged.motions.shared_mm.shape[2])
    radially[: len(by_rig)] = by_rig
    own = float(np.linalg.norm(spot.weight * part.noise.counting_mm[spot.index]))
    vibration = survey.sigma_vibration_mm / np.sqrt(2.0) if len(merged.parts) > 1 else 0.0
    return TreadPoint(
        sensor=part.sensor.name,
        place_mm=spot.in_rig_mm,
        single_mm=float(np.hypot(own, vibration)),
        shared_mm=spot.outward[:, None] * radially,
    )
