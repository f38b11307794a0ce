"""A simulated camera in a process of its own: its threads cost the caller's none of their time."""

import multiprocessing
import signal
import threading
from collections.abc import Callable
from multiprocessing.connection import Connection
from types import TracebackType
from typing import Any, Self

from station.errors import CameraError, CameraLost, StationError
from station.simulated.camera import SimulatedCamera, parse_address
from station.simulated.counters import Statistics
from station.simulated.device import DeviceOptions
from station.simulated.discovery import probe_camera
from station.simulated.faults import Faults
from station.simulated.sources import FrameSource

START_TIMEOUT_S = 120.0
_ANSWER_TIMEOUT_S = 30.0
_STOP = "stop"

MakeSource = Callable[[], FrameSource]
"""Makes the source within the new process; must be picklable: a function of a module, a partial."""


class SimulatedCameraProcess:
    """A `SimulatedCamera` elsewhere; its `make_source` is called there."""

    def __init__(
        self,
        address: str,
        make_source: MakeSource,
        *,
        serial: str | None = None,
        faults: Faults | None = None,
        options: DeviceOptions | None = None,
    ) -> None:
        self._address = parse_address(address)
        self._arguments = (address, make_source, serial, faults, options)
        # A forked child would inherit the caller's threads half alive; Aravis does not survive it.
        self._context = multiprocessing.get_context("spawn")
        self._process: multiprocessing.process.BaseProcess | None = None
        self._pipe: Connection | None = None
        self._lock = threading.Lock()
        self._final = Statistics()

    @property
    def address(self) -> str:
        return str(self._address)

    @property
    def pid(self) -> int | None:
        return None if self._process is None else self._process.pid

    def start(self) -> None:
        """Start the process and wait until the camera answers.

        Raises
        ------
        StationError
            What the camera's start or its source refused.
        CameraLost
            If the process ends or says nothing for two minutes.
        """
        if self._process is not None:
            return
        self._pipe, theirs = self._context.Pipe()
        process = self._context.Process(
            target=_run,
            args=(theirs, *self._arguments),
            name=f"camera {self._address}",
            daemon=True,
        )
        process.start()
        theirs.close()
        self._process = process
        try:
            self._receive(START_TIMEOUT_S)
            self._wait_for_discovery()
        except StationError:
            self.kill()
            raise

    def stop(self) -> None:
        """End the camera and its process; safe to call twice."""
        if self._process is None:
            return
        try:
            self._final = self._ask("statistics")
            self._ask(_STOP)
            self._process.join(_ANSWER_TIMEOUT_S)
        except CameraLost:
            pass  # it is what is wanted
        finally:
            self.kill()

    def kill(self) -> None:
        """End the process at once, as a power failure does; safe to call twice."""
        if self._process is None or self._pipe is None:
            return
        self._process.kill()
        self._process.join()
        self._pipe.close()
        self._process, self._pipe = None, None

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()

    def trigger_line1(self, timestamp_ns: int | None = None) -> bool:
        """Raise the trigger line; see `SimulatedCamera.trigger_line1`."""
        return bool(self._ask("trigger_line1", timestamp_ns))

    def freeze(self) -> None:
        """Answer and send nothing, as behind a cut cable; exposures go on."""
        self._ask("freeze")

    def thaw(self) -> None:
        """Answer and send again."""
        self._ask("thaw")

    def oust(self) -> None:
        """Take control from whoever has it; see `SimulatedCamera.oust`."""
        self._ask("oust")

    def statistics(self) -> Statistics:
        """Return what the camera has done; after `stop`, what it had done by then."""
        if self._process is not None:
            self._final = self._ask("statistics")
        return self._final

    def _ask(self, method: str, *arguments: object) -> Any:
        with self._lock:
            if self._pipe is None:
                raise CameraError(f"camera {self._address} does not run; start it first")
            try:
                self._pipe.send((method, arguments))
            except OSError as error:
                raise CameraLost(f"the process of camera {self._address} has ended") from error
            return self._receive(_ANSWER_TIMEOUT_S)

    def _receive(self, timeout_s: float) -> Any:
        if self._pipe is None or not self._pipe.poll(timeout_s):
            raise CameraLost(f"camera {self._address} said nothing for {timeout_s:.0f} s")
        try:
            answer = self._pipe.recv()
        except (EOFError, OSError) as error:
            raise CameraLost(f"the process of camera {self._address} has ended") from error
        if isinstance(answer, StationError):
            raise answer
        return answer

    def _wait_for_discovery(self) -> None:
        if probe_camera(self._address, timeout_s=_ANSWER_TIMEOUT_S) is None:
            raise CameraLost(f"camera {self._address} started but does not answer")


def _run(
    pipe: Connection,
    address: str,
    make_source: MakeSource,
    serial: str | None,
    faults: Faults | None,
    options: DeviceOptions | None,
) -> None:
    """Be the camera's process: obey the pipe until told to stop or the caller is gone."""
    # Ctrl-C at a terminal reaches every process; the caller decides when the camera ends.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        camera = SimulatedCamera(
            address, make_source(), serial=serial, faults=faults, options=options
        )
        camera.start()
    except StationError as error:
        pipe.send(error)
        return
    pipe.send(None)
    try:
        _obey(pipe, camera)
    except (EOFError, OSError):
        camera.stop()


def _obey(pipe: Connection, camera: SimulatedCamera) -> None:
    while True:
        method, arguments = pipe.recv()
        try:
            answer = getattr(camera, method)(*arguments)
        except StationError as error:
            answer = error
        pipe.send(answer)
        if method == _STOP:
            return
