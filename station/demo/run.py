"""The demo from the first rendered picture to the last reading, through the station's own doors."""

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import count
from pathlib import Path

from calib import Method
from station.client import Answer, StationClient
from station.demo.judgement import (
    PlaneJudgement,
    RigJudgement,
    WheelJudgement,
    judge_plane,
    judge_rig,
    judge_wheels,
)
from station.demo.rendering import frames_path, render_scenario
from station.demo.scenario import (
    AXLES,
    BOARD_SIGMA_MM,
    REFERENCE,
    SHOWINGS,
    RigTruth,
    Scenario,
    SensorTruth,
)
from station.demo.trackside import await_ready, cameras_of, roll_train_by, station_of
from station.documents import (
    CalibrationDocument,
    MeasurementDocument,
    RigDocument,
    WheelDocument,
)
from station.errors import StationError
from station.pipeline import calibrate_sources
from station.progress import Progress
from station.simulated import SimulatedCameraProcess

PASS_ID = "demo-train"
IN_FORCE = Method.JOINT
"""The method whose calibrations measure the train; the others solve the same points beside it."""

_JOB_PATIENCE_S = 300.0


@dataclass(frozen=True, slots=True)
class FrameAccount:
    """How the frames of one recording add up."""

    recording: str
    triggered: int
    recorded: int
    lost: int
    complete: bool


@dataclass(frozen=True, slots=True)
class DemoResult:
    """What the demo found; `good` when no frame was lost and every wheel was measured."""

    seed: int
    frames: tuple[FrameAccount, ...]
    planes: tuple[PlaneJudgement, ...]
    rigs: tuple[RigJudgement, ...]
    wheels: tuple[WheelJudgement, ...]

    @property
    def good(self) -> bool:
        """Whether every frame was recorded and every wheel measured."""
        return all(account.complete for account in self.frames) and all(
            wheel.reason is None for wheel in self.wheels
        )


@dataclass(frozen=True, slots=True)
class Calibrated:
    """What the station found for one rig before the train came.

    Attributes
    ----------
    sensors
        The answers for its sensors' own calibrations, by sensor.
    """

    sensors: Mapping[str, Answer]
    rig: RigDocument


def run_demo(folder: Path, seed: int, progress: Progress) -> DemoResult:
    """Play the demo; recordings, calibrations and results are left in `folder`.

    Raises
    ------
    StationError
        If a part of the chain refuses.
    """
    scenario = Scenario.draw(seed)
    with station_of(scenario, folder) as station:
        for done, total in render_scenario(scenario, folder):
            progress(0.3 * done / total, f"rendering picture {done} of {total}")
        with (
            cameras_of(scenario, folder) as cameras,
            StationClient.connect(station.url, station.key) as client,
        ):
            progress(0.3, "waiting for the station")
            await_ready(station, client)
            accounts = _show_target(scenario, client, progress)
            calibrated = _calibrate_all(scenario, client, progress)
            accounts += _record_train(client, cameras, progress)
            planes = _planes(scenario, folder, client, calibrated, progress)
            wheels = _wheels(scenario, folder, client, calibrated)
            progress(0.98, "stopping the station")
            station.stop()  # before its cameras go dark
    for truth in scenario.sensors:
        frames_path(folder, truth.id).unlink()
    rigs = [judge_rig(rig, calibrated[rig.id].rig) for rig in scenario.rigs]
    return DemoResult(seed, tuple(accounts), tuple(planes), tuple(rigs), tuple(wheels))


def _show_target(
    scenario: Scenario, client: StationClient, progress: Progress
) -> list[FrameAccount]:
    """Show the target to both rigs at once, all their sensors taking pictures."""
    taken = count(1)

    def show(rig: RigTruth) -> list[FrameAccount]:
        session = _session(rig)
        targets = {truth.id: str(truth.target) for truth in rig.sensors}
        client.open_rig_session(session, rig=rig.id, targets=targets)
        for _ in range(SHOWINGS):
            client.capture(session)
            number, total = next(taken), SHOWINGS * len(scenario.rigs)
            progress(0.3 + 0.15 * number / total, f"showing {number} of {total}")
        closed = client.finish_calibration_session(session)
        return _accounts(closed, {truth.id: SHOWINGS for truth in rig.sensors})

    with ThreadPoolExecutor(len(scenario.rigs)) as pool:
        return [account for found in pool.map(show, scenario.rigs) for account in found]


def _calibrate_all(
    scenario: Scenario, client: StationClient, progress: Progress
) -> dict[str, Calibrated]:
    """Have each sensor calibrated, then each rig, from the same pictures; activate the answers."""
    progress(0.45, "calibrating the sensors")
    pairs = [(rig, truth) for rig in scenario.rigs for truth in rig.sensors]
    with ThreadPoolExecutor(len(pairs)) as pool:
        answers = list(pool.map(lambda pair: _calibrate_sensor(client, *pair), pairs))
        own = {truth.id: answer for (_, truth), answer in zip(pairs, answers, strict=True)}
        progress(0.6, "calibrating the rigs")
        rigs = list(pool.map(lambda rig: _calibrate_rig(client, rig), scenario.rigs))
    return {
        rig.id: Calibrated({truth.id: own[truth.id] for truth in rig.sensors}, document)
        for rig, document in zip(scenario.rigs, rigs, strict=True)
    }


def _calibrate_sensor(client: StationClient, rig: RigTruth, truth: SensorTruth) -> Answer:
    answer = client.calibrate(
        sensor=truth.id, session=_session(rig), method=IN_FORCE, timeout_s=_JOB_PATIENCE_S
    )
    _ready(answer)
    client.activate(sensor=truth.id, calibration=answer["id"])
    return answer


def _calibrate_rig(client: StationClient, rig: RigTruth) -> RigDocument:
    answer = client.calibrate_rig(
        rig=rig.id,
        session=_session(rig),
        board_sigma_mm=BOARD_SIGMA_MM,
        timeout_s=_JOB_PATIENCE_S,
    )
    document = RigDocument.model_validate(_ready(answer))
    client.activate_rig(rig=rig.id, calibration=answer["id"])
    return document


def _record_train(
    client: StationClient, cameras: dict[str, SimulatedCameraProcess], progress: Progress
) -> list[FrameAccount]:
    progress(0.7, "train passing")
    client.arm_pass(PASS_ID, train="demo")
    triggers = roll_train_by(cameras)
    closed = client.finish_pass(PASS_ID, triggers=triggers, axles=AXLES)
    progress(0.8, "measuring")
    client.await_pass(PASS_ID, timeout_s=_JOB_PATIENCE_S)
    return _accounts(closed, triggers)


def _planes(
    scenario: Scenario,
    folder: Path,
    client: StationClient,
    calibrated: Mapping[str, Calibrated],
    progress: Progress,
) -> list[PlaneJudgement]:
    """Judge the station's own calibrations, and the same points solved by the other methods."""
    judged = []
    for rig in scenario.rigs:
        for truth in rig.sensors:
            answer = calibrated[rig.id].sensors[truth.id]
            points = folder / f"points-{truth.id}.csv"
            points.write_text(client.calibration_points(answer["id"]), encoding="utf-8")
            own = CalibrationDocument.model_validate(_ready(answer))
            for method in Method:
                progress(0.9, f"{truth.id}, {method}")
                document = own if method is IN_FORCE else _solved(truth, own, method, points)
                document.write(folder / f"calibration-{truth.id}-{method}.json")
                judged.append(judge_plane(truth, document))
    return judged


def _solved(
    truth: SensorTruth, own: CalibrationDocument, method: Method, points: Path
) -> CalibrationDocument:
    """Solve the points of a calibration by another method."""
    return calibrate_sources(
        [points],
        truth.target,
        sensor=truth.id,
        size_px=(own.camera.width, own.camera.height),
        method=method,
        mounting=own.mounting.settings() if own.mounting else None,
    ).document


def _wheels(
    scenario: Scenario,
    folder: Path,
    client: StationClient,
    calibrated: Mapping[str, Calibrated],
) -> list[WheelJudgement]:
    """Fetch and judge the wheels of the pass, and keep them beside their rigs."""
    rows = {row["id"]: row["wheel"] for row in client.wheels(PASS_ID)}
    axles = client.train(PASS_ID)["axles"]
    judged = []
    for rig in scenario.rigs:
        document = calibrated[rig.id].rig
        # By axle: on a busy machine triggers come late, and a wheel may be measured in two parts.
        wheels = {
            axle["number"]: WheelDocument.model_validate(rows[axle[rig.side]["measurement"]])
            for axle in axles
            if axle["number"] is not None and axle[rig.side]["measurement"] in rows
        }
        results = MeasurementDocument(
            created=datetime.now(UTC),
            software=document.software,
            calibration=None,
            calibrations=document.calibrations,
            rigs={rig.id: document.fingerprint},
            reference=REFERENCE,
            wheels=tuple(wheels[number] for number in sorted(wheels)),
        )
        document.write(folder / f"rig-{rig.id}.json")
        results.write(folder / f"results-{rig.id}.json")
        judged += judge_wheels(rig, wheels)
    return judged


def _session(rig: RigTruth) -> str:
    return f"demo-{rig.id}"


def _ready(answer: Answer) -> Answer:
    if answer["document"] is None:
        raise StationError(f"calibration {answer['id']} failed: {answer['reason']}")
    document: Answer = answer["document"]
    return document


def _accounts(closed: Answer, triggered: Mapping[str, int]) -> list[FrameAccount]:
    return [
        FrameAccount(
            recording=row["id"],
            triggered=triggered[row["sensor"]],
            recorded=row["recorded"] or 0,
            lost=row["lost"] or 0,
            complete=bool(row["complete"]) and row["recorded"] == triggered[row["sensor"]],
        )
        for row in closed["recordings"]
    ]
