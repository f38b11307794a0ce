"""Wheels before two sensors: rendered, by a calibrated rig, in every light, and shaken."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from calib import FloatArray, Rig
from measure import Quantity, Shot, Survey, WheelFrame, measure_wheel_on_rig, reference_profile
from station.bench.measure import SURVEYED_RAD
from station.bench.rig_pictures import BOARD_SIGMA_MM, SHOWINGS, BuiltRig
from station.bench.wheel_truths import errors_and_u95
from station.pipeline import locate_wheel_stripe, map_on_all_cores
from station.progress import Progress
from station.scenes import Light, WheelScene, WheelTruth
from station.tables import Table, Value

ASKED_GOOD_MM, ASKED_BAD_MM = 0.05, 0.08
ASKED_ADDED_MM = 0.02
VIBRATION_MM = 0.3
"""How far two sensors are apart from where they were, one sigma along each axis."""
READ = (
    Quantity.FLANGE_THICKNESS_10,
    Quantity.FLANGE_THICKNESS_12,
    Quantity.FLANGE_HEIGHT,
    Quantity.FLANGE_GRADIENT_QR,
)
_THICKNESS = READ[:2]
_RENDER_AND_MEASURE_S = 1.0
_WEAR_MM = (0.0, 8.0)
_OFF_MM = 30.0


class _Case(StrEnum):
    """What else is the matter with the wheels of a row."""

    STILL = ""
    SHAKEN = "shaken"
    NO_INNER = "inner dark"
    NO_OUTER = "outer dark"


@dataclass(frozen=True, slots=True, eq=False)
class _Wheel:
    """A wheel to be rendered for each sensor, and the rig to measure it by."""

    scenes: Mapping[str, WheelScene]
    rig: Rig
    dark: str | None
    seed: int


def bench_rig_wheels(
    progress: Progress, *, rigs: int = 2, wheels: int = 12, bad_wheels: int = 8, seed: int = 1
) -> Table:
    """Measure rendered wheels by rigs that were calibrated from rendered showings.

    Parameters
    ----------
    progress
        Told where the bench is.
    rigs
        Rigs in good light, each built and calibrated anew; and one in all lights.
    wheels, bad_wheels
        Wheels of each rig in good light, and of each bad light.
    seed
        Of all draws.
    """
    steps = rigs + 1
    rows: list[dict[str, Value]] = []
    drawn: dict[_Case, list[FloatArray]] = {case: [] for case in _Case}
    for number in range(rigs):
        progress(number / steps, f"rig {number + 1} of {rigs}")
        built = BuiltRig.from_pictures([Light.GOOD], seed + number)
        for case in _Case:
            drawn[case].append(_measured(_wheels(built, Light.GOOD, case, wheels, seed + number)))
    still = np.concatenate(drawn[_Case.STILL])
    rows.append(_row("good", still, ASKED_GOOD_MM))
    shaken = np.concatenate(drawn[_Case.SHAKEN])
    rows.append(_row(f"good, shaken by {VIBRATION_MM:g} mm", shaken, _with_added(still)))
    for case in (_Case.NO_INNER, _Case.NO_OUTER):
        rows.append(_row(f"good, {case.value}", np.concatenate(drawn[case]), None))
    progress(rigs / steps, "bad lights")
    mixed = BuiltRig.from_pictures(list(Light), seed)
    for done, light in enumerate(light for light in Light if light is not Light.GOOD):
        progress((rigs + done / (len(Light) - 1)) / steps, light.value)
        found = _measured(_wheels(mixed, light, _Case.STILL, bad_wheels, seed))
        rows.append(_row(light.value, found, ASKED_BAD_MM))
    notes = (
        f"Sensors tilted 45 degrees inwards and 28 outwards; each rig built with errors of its own "
        f"and calibrated from {SHOWINGS} showings, dots printed {BOARD_SIGMA_MM:g} mm off their "
        f"places; in good light {rigs} rigs, else one calibrated in all lights in turn. Wheels of "
        f"both references, worn 0 to {_WEAR_MM[1]:g} mm, one shot each, seed {seed}.",
        "RMS error over the wheels that gave the value, their number in brackets. Asked of flange "
        f"thickness: {ASKED_GOOD_MM:g} in good light, {ASKED_BAD_MM:g} in bad, by vibration no "
        f"more than {ASKED_ADDED_MM:g} added, none at all where a sensor is dark.",
    )
    return Table("Wheels by two sensors, mm RMS", rows, notes)


def _with_added(still: FloatArray) -> float:
    """Return what the RMS of thickness may be where sensors vibrate."""
    return max(_rms(still, place) for place in range(len(_THICKNESS))) + ASKED_ADDED_MM


def _wheels(built: BuiltRig, light: Light, case: _Case, count: int, seed: int) -> list[_Wheel]:
    # The same wheels in the same places in every case.
    rng = np.random.default_rng([seed, list(Light).index(light)])
    shaking = np.random.default_rng([seed, 99])
    tasks = []
    for number, wear_mm in enumerate(np.linspace(*_WEAR_MM, count)):
        moved = {
            each.name: shaking.normal(0.0, VIBRATION_MM / np.sqrt(2.0), 3)
            for each in built.truth.sensors
        }
        scenes = built.truth.shot(
            WheelTruth(
                ("S1002", "LMA")[number % 2],
                float(wear_mm),
                0.5 * float(wear_mm),
                radius_mm=float(rng.normal(420.0, 5.0)),
            ),
            axle_offset_mm=float(rng.uniform(-_OFF_MM, _OFF_MM)),
            lateral_shift_mm=float(rng.normal(0.0, 4.0)),
            light=light,
            seed=int(rng.integers(1 << 31)),
            vibration_mm=moved if case is _Case.SHAKEN else None,
        )
        dark = {_Case.NO_INNER: "inner", _Case.NO_OUTER: "outer"}.get(case)
        tasks.append(_Wheel(scenes, built.found, dark, number))
    return tasks


def _measured(wheels: Sequence[_Wheel]) -> FloatArray:
    """Return error and u95 of each reading, shape (N, Q, 2); NaN where it is missing."""
    answers = map_on_all_cores(
        _errors_and_u95, wheels, count=len(wheels), seconds_each=_RENDER_AND_MEASURE_S
    )
    return np.array(list(answers))


def _errors_and_u95(task: _Wheel) -> list[tuple[float, float]]:
    wheel = next(iter(task.scenes.values())).wheel
    shot = Shot(
        tuple(
            WheelFrame(
                locate_wheel_stripe(scene.render(np.random.default_rng([task.seed, place]))),
                0,
                "rendered",
                sensor=name,
            )
            for place, (name, scene) in enumerate(task.scenes.items())
            if name != task.dark
        )
    )
    survey = Survey(sigma_axle_direction_rad=SURVEYED_RAD, sigma_vibration_mm=VIBRATION_MM)
    reference = reference_profile(wheel.reference)
    return errors_and_u95(measure_wheel_on_rig([shot], task.rig, survey, reference), wheel, READ)


def _row(name: str, drawn: FloatArray, asked_mm: float | None) -> dict[str, Value]:
    row: dict[str, Value] = {"light": name, "wheels": len(drawn)}
    read = np.isfinite(drawn[:, :, 0])
    for place, quantity in enumerate(READ):
        count = int(read[:, place].sum())
        row[quantity.value] = f"{_rms(drawn, place):.3f} ({count})" if count else "missing"
    inside = np.abs(drawn[read][:, 0]) <= drawn[read][:, 1]
    worst = max(_rms(drawn, place) for place in range(len(_THICKNESS)))
    return row | {
        "largest error": float(np.abs(drawn[read][:, 0]).max()) if read.any() else float("nan"),
        "inside u95": float(inside.mean()) if read.any() else float("nan"),
        "asked": "missing" if asked_mm is None else f"<= {asked_mm:.3f}",
        "holds": not read[:, : len(_THICKNESS)].any() if asked_mm is None else worst <= asked_mm,
    }


def _rms(drawn: FloatArray, place: int) -> float:
    error = drawn[np.isfinite(drawn[:, place, 0]), place, 0]
    return float(np.sqrt(np.mean(error**2))) if len(error) else float("nan")
