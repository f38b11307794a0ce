"""The demo from the first rendered picture to the last reading, through the station's own doors."""

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from calib import Method
from station.client import Answer, StationClient
from station.demo.judgement import PlaneJudgement, WheelJudgement, judge_plane, judge_wheels
from station.demo.rendering import frames_path, render_scenario
from station.demo.scenario import TARGET, Scenario, SensorTruth
from station.demo.trackside import await_ready, cameras_of, roll_train_by, station_of
from station.documents import CalibrationDocument, WheelDocument
from station.errors import StationError
from station.operations import DataLayout
from station.pipeline import measure_sources
from station.progress import Progress
from station.simulated import SimulatedCameraProcess

PASS_ID = "demo-train"
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
            accounts = _record_targets(scenario, client, cameras, progress)
            solved = _calibrate(scenario, client, progress)
            accounts += _record_train(scenario, client, cameras, progress)
            live = _wheels_by_sensor(client)
            progress(0.88, "stopping the station")
            station.stop()  # before its cameras go dark
    for truth in scenario.sensors:
        frames_path(folder, truth.id).unlink()
    progress(0.9, "measuring with the other calibrations")
    return _judge(scenario, folder, accounts, solved, live)


Solved = Mapping[tuple[str, Method], CalibrationDocument]


def _record_targets(
    scenario: Scenario,
    client: StationClient,
    cameras: Mapping[str, SimulatedCameraProcess],
    progress: Progress,
) -> list[FrameAccount]:
    accounts = []
    for truth in scenario.sensors:
        client.open_calibration_session(_session(truth), sensor=truth.id, target=str(TARGET))
        for taken in range(1, len(truth.poses) + 1):
            client.capture(_session(truth))
            progress(0.3, f"{truth.id} pose {taken} of {len(truth.poses)}")
        closed = client.finish_calibration_session(_session(truth))
        accounts += _accounts(closed, {truth.id: len(truth.poses)})
    return accounts


def _calibrate(scenario: Scenario, client: StationClient, progress: Progress) -> Solved:
    orders = [(truth, method) for truth in scenario.sensors for method in Method]

    def solve(order: tuple[SensorTruth, Method]) -> Answer:
        truth, method = order
        return client.calibrate(
            sensor=truth.id, session=_session(truth), method=method, timeout_s=_JOB_PATIENCE_S
        )

    solved = {}
    with ThreadPoolExecutor(len(orders)) as pool:
        for done, (order, answer) in enumerate(
            zip(orders, pool.map(solve, orders), strict=True), start=1
        ):
            truth, method = order
            solved[truth.id, method] = _document(answer)
            if method is Method.JOINT:
                client.activate(sensor=truth.id, calibration=answer["id"])
            progress(0.4 + 0.3 * done / len(orders), f"{truth.id} calibrated, {method}")
    return solved


def _record_train(
    scenario: Scenario,
    client: StationClient,
    cameras: dict[str, SimulatedCameraProcess],
    progress: Progress,
) -> list[FrameAccount]:
    progress(0.7, "train passing")
    client.arm_pass(PASS_ID, train="demo")
    triggers = roll_train_by(scenario.sensors, cameras)
    closed = client.finish_pass(PASS_ID, triggers=triggers)
    progress(0.8, "measuring")
    client.await_pass(PASS_ID, timeout_s=_JOB_PATIENCE_S)
    return _accounts(closed, triggers)


def _wheels_by_sensor(client: StationClient) -> dict[str, list[WheelDocument]]:
    wheels: dict[str, list[WheelDocument]] = {}
    for row in client.wheels(PASS_ID):
        wheel = WheelDocument.model_validate(row["wheel"])
        wheels.setdefault(wheel.sensor, []).append(wheel)
    return wheels


def _judge(
    scenario: Scenario,
    folder: Path,
    accounts: list[FrameAccount],
    solved: Solved,
    live: Mapping[str, list[WheelDocument]],
) -> DemoResult:
    planes, wheels = [], []
    for truth in scenario.sensors:
        for method in Method:
            document = solved[truth.id, method]
            document.write(folder / f"calibration-{truth.id}-{method}.json")
            planes.append(judge_plane(truth, document))
            results = measure_sources([_recording(truth, folder)], document)
            results.write(folder / f"results-{truth.id}-{method}.json")
            # The joint calibration was in force: its readings are the station's own.
            in_force = method is Method.JOINT
            read = live.get(truth.id, []) if in_force else list(results.wheels)
            wheels += judge_wheels(truth, method, read)
    return DemoResult(scenario.seed, tuple(accounts), tuple(planes), tuple(wheels))


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
