"""A simulated camera, its capture process, and what was served, to compare with."""

import os
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from multiprocessing.process import BaseProcess
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np

from calib import Picture
from station.bench.processes import children_of, has_ended
from station.capture import (
    CaptureClient,
    CaptureReport,
    CaptureState,
    CaptureStatus,
    RecordingPlan,
    Trigger,
    start_capture,
)
from station.errors import CameraLost
from station.recording import EventKind, Rotation, events, frames
from station.settings import SensorSettings
from station.simulated import ArraySource, DeviceOptions, Faults, SimulatedCameraProcess

_NETWORK = "127.40"
"""Simulated cameras listen here: then comes a number of the process, for benches side by side."""
SENSOR = "bench"
_DISTINCT = 16
_PATIENCE_S = 30.0
_LOOK_S = 0.05
_END_S = 15.0


@dataclass(frozen=True, slots=True)
class Format:
    """What a camera sends; by default what the station's sensor does at its fastest."""

    width_px: int = 2048
    height_px: int = 1088
    rate_hz: float = 53.7

    @property
    def bytes_per_s(self) -> float:
        """Pixels a second."""
        return self.width_px * self.height_px * self.rate_hz

    def __str__(self) -> str:
        return f"{self.width_px} x {self.height_px} px at {self.rate_hz:g} frames/s"


def noise_pictures(width_px: int, height_px: int) -> list[Picture]:
    """Return pictures whose every byte depends on which it is."""
    rng = np.random.default_rng(53)
    shape = (height_px, width_px)
    return [rng.integers(0, 256, shape, dtype=np.uint8) for _ in range(_DISTINCT)]


class Rig:
    """A camera and its capture process while the block runs.

    Parameters
    ----------
    folder
        Takes socket and recordings.
    number
        Of the camera, 1 to 254: rigs side by side need different ones.
    """

    def __init__(
        self,
        folder: Path,
        *,
        number: int = 1,
        sends: Format | None = None,
        faults: Faults | None = None,
    ) -> None:
        self.sends = sends or Format()
        self.address = f"{_NETWORK}.{os.getpid() % 250 + 2}.{number}"
        self.path = folder / f"{number}.mcap"
        pictures = noise_pictures(self.sends.width_px, self.sends.height_px)
        self.served = ArraySource(pictures)
        # Sent over as they are: a process that drew them would first import all benches.
        self._make_source = partial(ArraySource, pictures)
        self._faults = faults
        self._socket_path = folder / f"{number}.sock"
        self._stack = ExitStack()

    def __enter__(self) -> Self:
        with self._stack as until_failure:
            self.camera = self._new_camera()
            until_failure.callback(lambda: self.camera.stop())
            self.camera.start()
            self.process = start_capture(self._settings(), self._socket_path)
            until_failure.callback(_end, self.process)
            self.client = CaptureClient(self._socket_path)
            self.wait_until(lambda status: status.state is CaptureState.IDLE)
            self.recorder_pid = children_of(self.capture_pid)[-1]
            self._stack = until_failure.pop_all()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stack.close()

    @property
    def capture_pid(self) -> int:
        """Process id of the receiver."""
        return self.process.pid or 0

    def arm(
        self,
        trigger: Trigger = Trigger.FREE,
        *,
        frames: int | None = None,
        rotation: Rotation | None = None,
        path: Path | None = None,
    ) -> Path:
        """Begin a recording; return where it goes."""
        path = path or self.path
        plan = RecordingPlan(
            path.stem, path, SENSOR, trigger, frames, rotation=rotation or Rotation()
        )
        self.client.arm(plan)
        return path

    def fire(self, count: int) -> None:
        """Raise the camera's trigger line so often, at its frame rate."""
        began_s = time.monotonic()
        for place in range(count):
            time.sleep(max(0.0, began_s + place / self.sends.rate_hz - time.monotonic()))
            self.camera.trigger_line1()

    def wait_until(
        self, reached: Callable[[CaptureStatus], bool], patience_s: float = _PATIENCE_S
    ) -> CaptureStatus:
        """Wait until the status is as wanted; CameraLost where it does not come to that."""
        until_s = time.monotonic() + patience_s
        while not reached(status := self.client.status()):
            if time.monotonic() > until_s:
                raise CameraLost(f"the bench's camera at {self.address} is {status}")
            time.sleep(_LOOK_S)
        return status

    def record(self, count: int) -> CaptureReport:
        """Record so many frames in free run."""
        self.arm(frames=count)
        patience_s = _PATIENCE_S + 2.0 * count / self.sends.rate_hz
        self.wait_until(lambda status: status.state is CaptureState.RECORDED, patience_s)
        return self.client.finish(expected_frames=count)

    def power_off_camera(self) -> None:
        """End the camera at once, as a power failure does."""
        self.camera.kill()

    def power_on_camera(self) -> None:
        """Start another camera at the same address; it answers when this returns."""
        self.camera = self._new_camera()
        self.camera.start()

    def _new_camera(self) -> SimulatedCameraProcess:
        return SimulatedCameraProcess(
            self.address,
            self._make_source,
            faults=self._faults,
            options=DeviceOptions(frame_rate_hz=self.sends.rate_hz),
        )

    def _settings(self) -> SensorSettings:
        return SensorSettings(
            id=SENSOR, address=self.address, trigger="free", frame_rate_hz=self.sends.rate_hz
        )


def differing(paths: Sequence[Path], served: ArraySource) -> int:
    """Return how many frames of recordings are not what the camera served, pixel for pixel.

    A camera that comes back begins anew with its pictures, while its frames are numbered on: the
    first that came of it is taken for its first.
    """
    return sum(_differing(path, served) for path in paths)


def _differing(path: Path, served: ArraySource) -> int:
    back_ns = deque(each.time_ns for each in events(path) if each.kind is EventKind.CAMERA_BACK)
    first, count = 1, 0
    for frame in frames(path):
        while back_ns and frame.host_time_ns > back_ns[0]:
            back_ns.popleft()
            first = frame.frame_id
        count += not np.array_equal(frame.picture, served.frame(frame.frame_id - first, 0.0))
    return count


def wait_for_end(pid: int, patience_s: float = _END_S) -> None:
    """Wait until a process is gone; TimeoutError where it is not."""
    until_s = time.monotonic() + patience_s
    while not has_ended(pid):
        if time.monotonic() > until_s:
            raise TimeoutError(f"process {pid} does not end")
        time.sleep(_LOOK_S)


def _end(process: BaseProcess) -> None:
    process.terminate()
    process.join(_END_S)
    process.kill()
    process.join()
