"""Whether the 95 % intervals of wheels before two sensors hold the truth 95 times of a hundred."""

from dataclasses import dataclass, replace

import numpy as np

from calib import FloatArray, Rig, RigidTransform, RigSensor, moved_by
from measure import OF_A_PROFILE, Shot, Survey, WheelFrame, measure_wheel_on_rig, reference_profile
from station.bench.drawing import ON_ALL_CORES, Drawing
from station.bench.measure_intervals import ASKED_SHARE, interval_row, sensor_beside
from station.bench.rig_pictures import SHOWINGS, BuiltRig
from station.bench.wheel_stripes import PlacedWheel, StripeNoise
from station.bench.wheel_truths import errors_and_u95
from station.progress import Progress
from station.scenes import Light, WheelRig, WheelTruth
from station.tables import Table, Value

_MEASURE_S = 0.08
_STEP_MM = 20.0
_BEND_SHARE = 0.5
"""How wrong the pull of a bend is drawn to be; `measure` allows it as much, one sigma."""


@dataclass(frozen=True, slots=True, eq=False)
class _Pass:
    """One wheel that passes a rig, everything about it drawn from a seed."""

    truth: WheelRig
    covariance: FloatArray
    shots: int
    seed: tuple[int, ...]


def bench_rig_intervals(
    progress: Progress,
    *,
    wheels: int = 600,
    several: int = 200,
    shots: int = 3,
    seed: int = 1,
    drawing: Drawing = ON_ALL_CORES,
) -> Table:
    """Draw everything a reading may be wrong by, as it is said to be, and count.

    Parameters
    ----------
    progress
        Told where the bench is.
    wheels, several
        How many wheels with one shot each, and with `shots` shots each, 20 mm apart.
    seed
        Of all draws.
    drawing
        Who does the draws.
    """
    built = BuiltRig.from_pictures([Light.GOOD], seed)
    rows: list[dict[str, Value]] = []
    for done, (count, drawn_wheels) in enumerate(((1, wheels), (shots, several))):
        progress(0.1 + 0.45 * done, f"{count} shots a wheel")
        tasks = [
            _Pass(built.truth, built.found.covariance, count, (seed, count, number))
            for number in range(drawn_wheels)
        ]
        answers = drawing.map(_errors_and_u95, tasks, seconds_each=_MEASURE_S * count)
        drawn = np.array(list(answers))
        rows += [
            interval_row(quantity, count, drawn[:, n]) for n, quantity in enumerate(OF_A_PROFILE)
        ]
    low, high = ASKED_SHARE
    notes = (
        "Wheels S1002 and LMA, worn 0 to 8 mm, before two sensors by geometry: noise and speckle "
        "of both stripes, pull of their bends, both sensors and their places (the covariance of a "
        f"rig calibrated from {SHOWINGS} rendered showings), vibration of each sensor in each "
        "shot, direction of the axle, height, radius and place all drawn from what is said of "
        "them.",
        f"Asked: {low} to {high}; luck alone moves a share of {several} by "
        f"{np.sqrt(0.0475 / several):.3f}, one sigma.",
    )
    return Table("Truth inside u95, two sensors", rows, notes)


def _errors_and_u95(task: _Pass) -> list[tuple[float, float]]:
    rng = np.random.default_rng(task.seed)
    survey = Survey()
    wheel = WheelTruth(
        reference=str(rng.choice(["S1002", "LMA"])),
        tread_wear_mm=float(rng.uniform(0.0, 8.0)),
        flange_wear_mm=float(rng.uniform(0.0, 4.0)),
        radius_mm=float(rng.normal(survey.wheel_radius_mm, survey.sigma_radius_mm)),
    )
    turn = rng.normal(size=3) * survey.sigma_axle_direction_rad * [1.0, 0.0, 1.0]
    track = RigidTransform.from_rotation_vector(turn, np.zeros(3))
    lifted, lateral = rng.normal(size=2) * [survey.sigma_height_mm, 4.0]
    # The field of view is no wider: farther aside the trigger would not have come.
    middle = rng.uniform(-1.0, 1.0) * survey.sigma_axle_x_mm
    pulls = 1.0 + _BEND_SHARE * rng.normal(size=len(task.truth.sensors))
    shots = []
    for number in range(task.shots):
        place = PlacedWheel(
            wheel,
            task.truth.sensors[0].sensor,
            track,
            float(middle + _STEP_MM * (number - (task.shots - 1) / 2.0)),
            float(lateral),
            float(lifted),
        )
        shots.append(_shot(place, task.truth, track, survey, pulls, number, rng))
    rig = _drawn_rig(task.truth, task.covariance, rng)
    answer = measure_wheel_on_rig(shots, rig, survey, reference_profile(wheel.reference))
    return errors_and_u95(answer, wheel, OF_A_PROFILE)


def _shot(
    place: PlacedWheel,
    truth: WheelRig,
    track: RigidTransform,
    survey: Survey,
    pulls: FloatArray,
    number: int,
    rng: np.random.Generator,
) -> Shot:
    """Draw the stripes of all sensors at one moment, each where it has vibrated to."""
    frames = []
    for each, pull in zip(truth.sensors, pulls, strict=True):
        sway = np.append(survey.sigma_vibration_rad, np.zeros(2))
        vibration = rng.normal(size=6) * np.append(sway, np.full(3, survey.sigma_vibration_mm))
        pose = moved_by(track @ each.rig_from_camera, vibration / np.sqrt(2.0))
        before = replace(place, sensor=each.sensor, rig_from_camera=pose)
        stripe = before.stripe(rng, StripeNoise(), pull=float(pull))
        frames.append(WheelFrame(stripe, number, "drawn", sensor=each.name))
    return Shot(tuple(frames))


def _drawn_rig(truth: WheelRig, covariance: FloatArray, rng: np.random.Generator) -> Rig:
    """Return the rig as a calibration of that covariance may have found it."""
    nowhere = np.zeros(len(covariance))
    steps = rng.multivariate_normal(nowhere, covariance, check_valid="ignore")
    sensors = []
    for each, step in zip(truth.sensors, np.split(steps, len(truth.sensors)), strict=True):
        pose = moved_by(each.rig_from_camera, step[13:])
        sensor = sensor_beside(each.sensor, step[:13], covariance[:13, :13])
        sensors.append(RigSensor(each.name, sensor, pose))
    return Rig(tuple(sensors), covariance)
