"""Passes in the middle of which a process of the station is killed, and what they come to."""

import os
import tempfile
import time
from collections.abc import Generator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from threading import Event

import numpy as np

from station.bench.service.blind_controller import BlindController
from station.bench.service.pass_truth import PassTruth, left_over, truth_of_pass
from station.bench.service.small_sensor import (
    SENSOR,
    KeptPictures,
    bring_calibration_into_force,
    render_wheels,
)
from station.bench.service.station_process import PATIENCE_S, StationProcess, Victim
from station.progress import Progress
from station.scenes import trackside_mounting
from station.simulated import SimulatedCameraProcess
from station.store import Store

_NETWORK = "127.33"
"""Simulated cameras listen here, at other addresses for benches side by side."""
_PICTURES = 4
_WHEEL_S = 0.12
"""From wheel to wheel: frames that follow each other more closely would count as one wheel."""
_BEFORE_S, _WARNING_S, _AFTER_S = 0.2, 0.8, 1.0
"""Before the controller arms; from there to the first wheel; from the last one to the end."""
_KEPT_S = 1.1
"""So long the station may answer how ready it is as it was before."""
_ENDED = {"done", "failed", "recovered"}


@dataclass(frozen=True, slots=True)
class Train:
    """What goes by in every pass."""

    wheels: int = 12

    @property
    def lasts_s(self) -> float:
        """From just before it is announced until it has been measured, about."""
        return _BEFORE_S + _WARNING_S + self.wheels * _WHEEL_S + _AFTER_S


@dataclass(frozen=True, slots=True)
class Trial:
    """What one kill came to."""

    victim: Victim
    after_s: float
    """When it was killed, since just before the pass was announced."""
    state: str
    reason: str
    ready_s: float
    """From the kill until every part was ready again."""
    truth: PassTruth
    left_over: Sequence[str]
    next_whole: bool
    """Whether the next train was recorded whole."""
    server_errors: int

    @property
    def good(self) -> bool:
        """Whether nothing was lost but what is said to be, and nothing is there twice."""
        truth = self.truth
        wrong = truth.unsaid + truth.unsound + truth.missing + truth.doubled + truth.differing
        ended = self.state in _ENDED and (self.state != "failed" or truth.recorded == 0)
        return ended and not wrong and not self.left_over and self.next_whole


@dataclass(frozen=True, slots=True)
class Stage:
    """A station, what its camera sees, and its store to look into."""

    station: StationProcess
    camera: SimulatedCameraProcess
    store: Store


def run_kills(
    progress: Progress, *, kills: int, victims: Sequence[Victim], train: Train, seed: int
) -> list[Trial]:
    """Return what each kill came to; the processes are killed in turn."""
    rng = np.random.default_rng(seed)
    order = [victim for _ in range(kills) for victim in victims]
    trials: list[Trial] = []
    with (
        tempfile.TemporaryDirectory(prefix="treadline-bench-") as folder,
        stage_in(Path(folder)) as stage,
    ):
        for place, victim in enumerate(order):
            progress(place / len(order), f"kill {place + 1} of {len(order)}: {victim}")
            after_s = float(rng.uniform(0.0, train.lasts_s))
            trials.append(_try(stage, victim, after_s, f"p{place:03}", train))
    return trials


@contextmanager
def stage_in(folder: Path, store_url: str | None = None) -> Generator[Stage]:
    """Run a station that has a calibration in force, before a camera that sees wheels."""
    pictures = KeptPictures.keep(render_wheels(_PICTURES), folder / "pictures.npy")
    address = f"{_NETWORK}.{os.getpid() % 250 + 2}.{folder.stat().st_ino % 250 + 2}"
    station = StationProcess(folder, _settings(address), SENSOR, store_url=store_url)
    bring_calibration_into_force(station.layout)
    store = Store.open(station.layout.store_url)
    with SimulatedCameraProcess(address, pictures, serial=SENSOR) as camera:
        try:
            station.start()
            station.wait_until_ready()
            yield Stage(station, camera, store)
        finally:
            station.ensure_ended()
            store.close()


def _settings(address: str) -> str:
    mounting = trackside_mounting("left")
    return "\n".join([
        "[storage]",
        "keep_free_gb = 0.0",
        "most_axles = 100",
        "[[sensors]]",
        f'id = "{SENSOR}"',
        f'address = "{address}"',
        "[sensors.mounting]",
        f"rotation_vector = {mounting.rotation_vector.tolist()}",
        f"translation_mm = {mounting.translation_mm.tolist()}",
        "",
    ])


def _try(stage: Stage, victim: Victim, after_s: float, pass_id: str, train: Train) -> Trial:
    gone = Event()
    with stage.station.client() as client, ThreadPoolExecutor(2) as beside:
        controller = BlindController(client, SENSOR, PATIENCE_S)
        killed = beside.submit(_kill_after, stage.station, victim, after_s)
        time.sleep(_BEFORE_S)
        taken = beside.submit(controller.take_pass, pass_id, axles=train.wheels, gone=gone)
        time.sleep(_WARNING_S)
        roll_by(stage.camera, train.wheels)
        gone.set()
        ready_s, answer = killed.result(), taken.result()
    truth = truth_of_pass(stage.store, stage.station.layout, pass_id, train.wheels)
    next_whole = _next_is_whole(stage, f"{pass_id}-next")
    return Trial(
        victim=victim,
        after_s=after_s,
        state=str(answer.get("state", "unknown")),
        reason=str(answer.get("reason") or ""),
        ready_s=ready_s,
        truth=truth,
        left_over=_settled(stage),
        next_whole=next_whole,
        server_errors=controller.server_errors,
    )


def _kill_after(station: StationProcess, victim: Victim, after_s: float) -> float:
    """Kill a process at a moment; return the seconds until all was well again."""
    time.sleep(after_s)
    before = station.pid_of(victim)
    station.kill(victim)
    killed_s = time.monotonic()
    if victim is Victim.SUPERVISOR:
        station.start()
    station.wait(lambda: station.pid_of(victim) not in {None, before}, f"for another {victim}")
    if victim is not Victim.RECORDER:  # of which readiness knows nothing
        time.sleep(max(0.0, killed_s + _KEPT_S - time.monotonic()))
        station.wait_until_ready()
    return time.monotonic() - killed_s


def roll_by(camera: SimulatedCameraProcess, wheels: int) -> None:
    """Trigger the camera as so many wheels come by."""
    began_s = time.monotonic()
    for wheel in range(wheels):
        time.sleep(max(0.0, began_s + wheel * _WHEEL_S - time.monotonic()))
        camera.trigger_line1()


def _next_is_whole(stage: Stage, pass_id: str, wheels: int = 2) -> bool:
    """Take another pass that nobody disturbs; tell whether every wheel of it was recorded."""
    gone = Event()
    with stage.station.client() as client, ThreadPoolExecutor(1) as beside:
        client.arm_pass(pass_id)
        roll_by(stage.camera, wheels)
        gone.set()
        controller = BlindController(client, SENSOR, PATIENCE_S)
        answer = beside.submit(controller.take_pass, pass_id, axles=wheels, gone=gone).result()
    return bool(answer.get("state") == "done" and answer["recordings"][0]["complete"])


def _settled(stage: Stage, patience_s: float = 10.0) -> list[str]:
    """Return what is left over once the station has had time to put it away."""
    until_s = time.monotonic() + patience_s
    while (found := left_over(stage.station, stage.store)) and time.monotonic() < until_s:
        time.sleep(0.1)
    return found
