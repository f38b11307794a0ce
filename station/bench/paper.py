"""The paper's Tables 4 and 5: what each way of calibrating measures, on rendered pictures."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib import (
    CalibError,
    CylinderReading,
    LaserSensor,
    Method,
    View,
    calibrate,
    judge_cylinder,
    judge_cylinders,
    judge_distances,
)
from station.bench.paper_pictures import (
    BAD_LIGHTS,
    RADIUS_MM,
    TARGET,
    SeenCylinder,
    see_cylinders,
    see_targets,
)
from station.progress import Progress
from station.scenes import Light, paper_sensor
from station.tables import Table, Value

# The paper's four placements; in bad light two more, so that every light is among them.
_PLACEMENTS = {"good": 4, "bad": len(BAD_LIGHTS)}
_CYLINDERS = 9
_LIGHTS = {"good": (Light.GOOD,), "bad": BAD_LIGHTS}
_NAMES = {"good": "CII", "bad": "CNII"}
# Tables 4 and 5 of the paper, mm: distances and radius.
_OF_PAPER: dict[tuple[str, bool], tuple[Value, Value]] = {
    ("good", False): (0.0475, 0.0718),
    ("bad", False): (0.2282, 0.3664),
    ("good", True): (0.0381, 0.0607),
    ("bad", True): (0.1036, 0.0725),
}


@dataclass(frozen=True, slots=True, eq=False)
class _Gauges:
    """What the calibrations are tried on: the same pictures for all of them."""

    placements: Sequence[View]
    cylinders: Sequence[SeenCylinder]

    @classmethod
    def seen(cls, sensor: LaserSensor, quality: str, seed: int) -> "_Gauges":
        lights = _LIGHTS[quality]
        targets = see_targets(sensor, lights, _PLACEMENTS[quality], [seed, 1])
        return cls(
            [seen.view for seen in targets], see_cylinders(sensor, lights, _CYLINDERS, [seed, 2])
        )


def bench_paper(progress: Progress, *, poses: int = 20, seed: int = 1) -> Table:
    """Calibrate from good and from bad pictures by every method, and measure with each.

    Parameters
    ----------
    progress
        Told where the bench is.
    poses
        Pictures a calibration.
    seed
        Of poses and noise.
    """
    sensor = paper_sensor()
    gauges = {}
    for place, quality in enumerate(_LIGHTS):
        progress(0.15 * place, f"gauges in {quality} light")
        gauges[quality] = _Gauges.seen(sensor, quality, seed)
    rows: list[dict[str, Value]] = []
    for place, (quality, lights) in enumerate(_LIGHTS.items()):
        progress(0.3 + 0.35 * place, f"calibrating in {quality} light")
        views = [seen.view for seen in see_targets(sensor, lights, poses, [seed, 3, place])]
        for method in Method:
            answer = _sensor_of(views, sensor, method)
            paper = _OF_PAPER[quality, method is not Method.PREPLANAR]
            rows.append(_row(_name(quality, method), answer, gauges, paper))
    rows.append(_row("true sensor", sensor, gauges, ("", "")))
    return Table("Distances and radius, RMS error in mm", rows, _notes(poses, seed))


def _name(quality: str, method: Method) -> str:
    corrected = "" if method is Method.PREPLANAR else "DC"
    return f"{_NAMES[quality]}{corrected} ({method})"


def _notes(poses: int, seed: int) -> tuple[str, ...]:
    return (
        f"{poses} pictures of {TARGET} a calibration, camera known, seed {seed}: CII in good "
        "light, CNII in the six bad lights in turn, DC with deviations corrected. All are tried "
        f"on the same {_PLACEMENTS['good']} placements of the target in good light and "
        f"{_PLACEMENTS['bad']} in bad, and {_CYLINDERS} each of a cylinder of {RADIUS_MM:g} mm "
        "radius. Left out: placements whose stripe is none of the sheet's, as a second one in "
        "stray light.",
        "Axis known: the direction of the cylinder's axis is held at the truth, as a fixture "
        f"gives it. Axis free: found with the radius that all {_CYLINDERS} placements share; a "
        "picture alone, an arc of 150 degrees, tells tilt and radius hardly apart.",
    )


def _sensor_of(views: Sequence[View], truth: LaserSensor, method: Method) -> LaserSensor | None:
    camera = truth.camera
    try:
        return calibrate(
            views, TARGET, width=camera.width, height=camera.height, camera=camera, method=method
        ).sensor
    except CalibError:
        return None


def _row(
    name: str,
    sensor: LaserSensor | None,
    gauges: dict[str, _Gauges],
    paper: tuple[Value, Value],
) -> dict[str, Value]:
    row: dict[str, Value] = {"calibration": name}
    for quality, gauge in gauges.items():
        row[f"distances, {quality}"] = _distances_rms(gauge, sensor)
    row["left out, bad"] = _left_out(gauges["bad"], sensor)
    row["distances, paper"] = paper[0]
    for quality, gauge in gauges.items():
        row[f"radius, {quality}, axis known"] = _radius_rms(gauge, sensor, axis_known=True)
    for quality, gauge in gauges.items():
        row[f"radius, {quality}, axis free"] = _radius_rms(gauge, sensor, axis_known=False)
    row["radius, paper"] = paper[1]
    return row


def _distances_rms(gauges: _Gauges, sensor: LaserSensor | None) -> Value:
    if sensor is None:
        return "refused"
    placements = judge_distances(gauges.placements, TARGET, sensor)
    return _rms([error for placement in placements for error in placement.errors_mm.tolist()])


def _left_out(gauges: _Gauges, sensor: LaserSensor | None) -> Value:
    if sensor is None:
        return "refused"
    placements = judge_distances(gauges.placements, TARGET, sensor)
    unmeasured = sum(bool(placement.reason) for placement in placements)
    return unmeasured + _PLACEMENTS["bad"] - len(placements)


def _radius_rms(gauges: _Gauges, sensor: LaserSensor | None, *, axis_known: bool) -> Value:
    if sensor is None:
        return "refused"
    if axis_known:
        readings: Sequence[CylinderReading] = [
            judge_cylinder(
                seen.stripe, sensor, RADIUS_MM, name=seen.name, axis_in_cam=seen.axis_in_cam
            )
            for seen in gauges.cylinders
        ]
    else:
        stripes = [(seen.name, seen.stripe) for seen in gauges.cylinders]
        readings = judge_cylinders(stripes, sensor, RADIUS_MM).readings
    unread = [reading for reading in readings if reading.reason]
    if unread:
        return f"{len(unread)} of {len(readings)} unread"
    return _rms([reading.radius_mm - RADIUS_MM for reading in readings])


def _rms(errors_mm: list[float]) -> Value:
    return float(np.sqrt(np.mean(np.square(errors_mm)))) if errors_mm else "none measured"
