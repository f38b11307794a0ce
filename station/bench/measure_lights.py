"""Wheels in every light, by a sensor calibrated in the same light, and soiled wheels."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib import FloatArray, LaserSensor, calibrate
from measure import Mounting, Quantity, WheelFrame, measure_wheel, reference_profile
from station.bench.lights import TARGET, observe_light
from station.bench.wheel_truths import errors_and_u95
from station.pipeline import locate_wheel_stripe, map_on_all_cores
from station.progress import Progress
from station.scenes import (
    Light,
    Soiling,
    WheelFaults,
    WheelScene,
    WheelTruth,
    paper_sensor,
    trackside_mounting,
)
from station.tables import Table, Value

FAULTS = {
    "polished steel": WheelFaults(mirror_share=0.25),
    "sun through a slit": WheelFaults(sun_stripe=0.4),
    "dirt": WheelFaults(soiling=Soiling(gaps=3, lumps=2)),
    "grease and rust": WheelFaults(soiling=Soiling(grease=0.8, rust=2.0)),
    "rolled bright": WheelFaults(soiling=Soiling(burnish=6.0)),
}
"""What is wrong with the wheels of the last rows, in good light otherwise."""

ASKED_GOOD_MM = {
    Quantity.TREAD_WEAR: 0.02,
    Quantity.FLANGE_HEIGHT: 0.02,
    Quantity.FLANGE_THICKNESS_10: 0.03,
    Quantity.FLANGE_GRADIENT_QR: 0.06,
}
ASKED_BAD_MM = 0.05
_RENDER_AND_MEASURE_S = 0.6
_WEAR_MM = (0.0, 8.0)
_OFF_MM = 60.0  # along the rail: up to 30 mm beside the sheet


@dataclass(frozen=True, slots=True, eq=False)
class _Picture:
    """A wheel to be rendered, and the calibrated sensor to measure it with."""

    scene: WheelScene
    sensor: LaserSensor
    noise_seed: int


def bench_measure_lights(
    progress: Progress, *, wheels: int = 12, poses: int = 20, seed: int = 1
) -> Table:
    """Measure worn wheels in each light with a sensor calibrated in that light.

    Parameters
    ----------
    progress
        Told where the bench is.
    wheels
        Wheels a row, one picture each.
    poses
        Pictures that a sensor is calibrated from.
    seed
        Of wheels, poses and noise.
    """
    sensors: dict[Light, LaserSensor] = {}
    rows: list[dict[str, Value]] = []
    steps = len(Light) + len(FAULTS)
    for light in Light:
        progress(len(rows) / steps, light.value)
        sensors[light] = calibrated_in(light, poses=poses, seed=seed)
        scenes = worn_wheels(light, count=wheels, seed=seed)
        rows.append(_row(light.value, _measured(scenes, sensors[light]), light is Light.GOOD))
    for name, faults in FAULTS.items():
        progress(len(rows) / steps, name)
        scenes = [
            replace(scene, faults=faults)
            for scene in worn_wheels(Light.GOOD, count=wheels, seed=seed)
        ]
        rows.append(_row(name, _measured(scenes, sensors[Light.GOOD]), False))
    good = ", ".join(f"{asked:g}" for asked in ASKED_GOOD_MM.values())
    notes = (
        f"{wheels} wheels a row, both references, tread worn {_WEAR_MM[0]:g} to {_WEAR_MM[1]:g} mm "
        f"and flange half as much, axles up to 30 mm beside the sheet, one picture each; sensor "
        f"calibrated from {poses} pictures of {TARGET} in the same light, seed {seed}.",
        "RMS error over the wheels that gave the value, their number in brackets: what is not "
        f"seen is missing, not guessed. Asked: {good} in good light, {ASKED_BAD_MM:g} elsewhere.",
    )
    return Table("Wheels by light, sensor calibrated in it, mm RMS", rows, notes)


def calibrated_in(light: Light, *, poses: int, seed: int) -> LaserSensor:
    """Return the sensor as a joint calibration from rendered pictures in one light gives it."""
    truth = paper_sensor()
    views, _ = observe_light(light, truth, poses=poses, seed=seed)
    camera = truth.camera
    return calibrate(views, TARGET, width=camera.width, height=camera.height, camera=camera).sensor


def worn_wheels(light: Light, *, count: int, seed: int) -> list[WheelScene]:
    """Return wheels of both references, worn evenly over the range, placed and soiled by chance."""
    sensor, rig = paper_sensor(), trackside_mounting("left")
    by_chance = np.random.default_rng([seed, list(Light).index(light)])
    return [
        WheelScene(
            sensor,
            rig,
            WheelTruth(("S1002", "LMA")[number % 2], float(wear_mm), 0.5 * float(wear_mm)),
            axle_offset_mm=float(by_chance.uniform(-_OFF_MM, _OFF_MM)),
            lateral_shift_mm=float(by_chance.normal(0.0, 4.0)),
            light=light,
            seed=int(by_chance.integers(1 << 31)),
        )
        for number, wear_mm in enumerate(np.linspace(*_WEAR_MM, count))
    ]


def _measured(scenes: Sequence[WheelScene], sensor: LaserSensor) -> FloatArray:
    """Return error and u95 of each reading, shape (N, Q, 2); NaN where it is missing."""
    tasks = [_Picture(scene, sensor, number) for number, scene in enumerate(scenes)]
    answers = map_on_all_cores(
        _errors_and_u95, tasks, count=len(tasks), seconds_each=_RENDER_AND_MEASURE_S
    )
    return np.array(list(answers))


def _errors_and_u95(picture: _Picture) -> list[tuple[float, float]]:
    scene = picture.scene
    stripe = locate_wheel_stripe(scene.render(np.random.default_rng(picture.noise_seed)))
    answer = measure_wheel(
        [WheelFrame(stripe, 0, "rendered")],
        picture.sensor,
        reference_profile(scene.wheel.reference),
        mounting=Mounting(scene.rig_from_camera),
    )
    return errors_and_u95(answer, scene.wheel, ASKED_GOOD_MM)


def _row(name: str, drawn: FloatArray, good: bool) -> dict[str, Value]:
    row: dict[str, Value] = {"light or fault": name}
    holds = True
    for place, (quantity, asked_good_mm) in enumerate(ASKED_GOOD_MM.items()):
        error = drawn[np.isfinite(drawn[:, place, 0]), place, 0]
        rms = float(np.sqrt(np.mean(error**2))) if len(error) else float("nan")
        holds &= rms <= (asked_good_mm if good else ASKED_BAD_MM)
        row[quantity.value] = f"{rms:.3f} ({len(error)})" if len(error) else "missing"
    read = np.isfinite(drawn[:, :, 0])
    inside = np.abs(drawn[:, :, 0]) <= drawn[:, :, 1]
    largest = float(np.abs(drawn[read][:, 0]).max()) if read.any() else float("nan")
    row |= {
        "largest error": largest,
        "inside u95": float(inside[read].mean()) if read.any() else float("nan"),
        "holds": bool(holds),
    }
    return row
