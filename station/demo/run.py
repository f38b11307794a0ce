"""The demo from the first rendered picture to the last reading, through the station's own doors."""

from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import count
from pathlib import Path

from calib import Method
from station.client import Answer, StationClient
from station.demo.judgement import PlaneJudgement, WheelJudgement, judge_plane, judge_wheels
from station.demo.rendering import frames_path, render_scenario
from station.demo.scenario import AXLES, REFERENCE, TARGET, Scenario, SensorTruth
from station.demo.trackside import await_ready, cameras_of, roll_train_by, station_of
from station.documents import CalibrationDocument, MeasurementDocument, WheelDocument
from station.errors import StationError
from station.operations import DataLayout
from station.pipeline import calibrate_sources, measure_sources
from station.progress import Progress
from station.simulated import SimulatedCameraProcess

PASS_ID = "demo-train"
IN_FORCE = Method.JOINT
"""The method whose calibrations measure the train; the others solve the same points beside it."""

_JOB_PATIENCE_S = 120.0


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
    wheels: tuple[WheelJudgement, ...]

    @property
    def good(self) -> bool:
        """Whether every frame was recorded and every wheel measured."""
        return all(account.complete for account in self.frames) and all(
            wheel.reason is None for wheel in self.wheels
        )


@dataclass(frozen=True, slots=True)
class Kept:
    """What the station found for one sensor."""

    document: CalibrationDocument
    points_csv: str
    results: MeasurementDocument


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
            progress(0.25 * done / total, f"rendering picture {done} of {total}")
        with (
            cameras_of(scenario, folder) as cameras,
            StationClient.connect(station.url, station.key) as client,
        ):
            progress(0.28, "waiting for the station")
            await_ready(station, client)
            accounts, answers = _calibrate_all(scenario, client, progress)
            accounts += _record_train(scenario, client, cameras, progress)
            kept = _keep(client, answers)
            progress(0.88, "stopping the station")
            station.stop()  # before its cameras go dark
    for truth in scenario.sensors:
        frames_path(folder, truth.id).unlink()
    return _judge(scenario, folder, accounts, kept, progress)


def _calibrate_all(
    scenario: Scenario, client: StationClient, progress: Progress
) -> tuple[list[FrameAccount], dict[str, Answer]]:
    """Take the pictures and have them calibrated, all sensors at once; activate the answers."""
    total = sum(len(truth.poses) for truth in scenario.sensors)
    taken = count(1)

    def took_one() -> None:
        number = next(taken)
        progress(0.3 + 0.2 * number / total, f"pose {number} of {total}, calibrating")

    def calibrate(truth: SensorTruth) -> tuple[list[FrameAccount], Answer]:
        accounts = _record_target(truth, client, took_one)
        answer = client.calibrate(
            sensor=truth.id,
            session=_session(truth),
            method=IN_FORCE,
            timeout_s=_JOB_PATIENCE_S,
        )
        client.activate(sensor=truth.id, calibration=answer["id"])
        return accounts, answer

    with ThreadPoolExecutor(len(scenario.sensors)) as pool:
        outcomes = list(pool.map(calibrate, scenario.sensors))
    accounts = [account for found, _ in outcomes for account in found]
    answers = [answer for _, answer in outcomes]
    return accounts, {s.id: answer for s, answer in zip(scenario.sensors, answers, strict=True)}


def _record_target(
    truth: SensorTruth, client: StationClient, took_one: Callable[[], None]
) -> list[FrameAccount]:
    session = _session(truth)
    client.open_calibration_session(session, sensor=truth.id, target=str(TARGET))
    for _ in truth.poses:
        client.capture(session)
        took_one()
    closed = client.finish_calibration_session(session)
    return _accounts(closed, {truth.id: len(truth.poses)})


def _record_train(
    scenario: Scenario,
    client: StationClient,
    cameras: dict[str, SimulatedCameraProcess],
    progress: Progress,
) -> list[FrameAccount]:
    progress(0.7, "train passing")
    client.arm_pass(PASS_ID, train="demo")
    triggers = roll_train_by(scenario.sensors, cameras)
    closed = client.finish_pass(PASS_ID, triggers=triggers, axles=AXLES)
    progress(0.8, "measuring")
    client.await_pass(PASS_ID, timeout_s=_JOB_PATIENCE_S)
    return _accounts(closed, triggers)


def _keep(client: StationClient, answers: Mapping[str, Answer]) -> dict[str, Kept]:
    """Fetch what the station found: calibrations, their points, the wheels of the pass."""
    rows = client.wheels(PASS_ID)
    kept = {}
    for sensor_id, answer in answers.items():
        document = _document(answer)
        wheels = [row["wheel"] for row in rows if row["sensor"] == sensor_id]
        results = MeasurementDocument(
            created=datetime.now(UTC),
            software=document.software,
            calibration=document.fingerprint,
            reference=REFERENCE,
            wheels=tuple(WheelDocument.model_validate(wheel) for wheel in wheels),
        )
        kept[sensor_id] = Kept(document, client.calibration_points(answer["id"]), results)
    return kept


def _judge(
    scenario: Scenario,
    folder: Path,
    accounts: list[FrameAccount],
    kept: Mapping[str, Kept],
    progress: Progress,
) -> DemoResult:
    planes, wheels = [], []
    for truth in scenario.sensors:
        for method in Method:
            progress(0.9, f"{truth.id}, {method}")
            document, results = _answers(truth, method, folder, kept[truth.id])
            document.write(folder / f"calibration-{truth.id}-{method}.json")
            results.write(folder / f"results-{truth.id}-{method}.json")
            planes.append(judge_plane(truth, document))
            wheels += judge_wheels(truth, method, results.wheels)
    return DemoResult(scenario.seed, tuple(accounts), tuple(planes), tuple(wheels))


def _answers(
    truth: SensorTruth, method: Method, folder: Path, kept: Kept
) -> tuple[CalibrationDocument, MeasurementDocument]:
    """Return the station's own answer, or solve the same points by another method and measure."""
    if method is IN_FORCE:
        return kept.document, kept.results
    points = folder / f"points-{truth.id}.csv"
    points.write_text(kept.points_csv, encoding="utf-8")
    camera = kept.document.camera
    document = calibrate_sources(
        [points],
        TARGET,
        sensor=truth.id,
        size_px=(camera.width, camera.height),
        method=method,
        mounting=kept.document.mounting.settings() if kept.document.mounting else None,
    ).document
    return document, measure_sources([_recording(truth, folder)], document)


def _recording(truth: SensorTruth, folder: Path) -> Path:
    return DataLayout(folder).root / DataLayout(folder).pass_recording(PASS_ID, truth.id)


def _session(truth: SensorTruth) -> str:
    return f"demo-{truth.id}"


def _document(answer: Answer) -> CalibrationDocument:
    if answer["document"] is None:
        raise StationError(f"calibration {answer['id']} failed: {answer['reason']}")
    return CalibrationDocument.model_validate(answer["document"])


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
