"""A station at work: its camera, its client, and what each of its processes uses."""

from contextlib import ExitStack
from types import TracebackType
from typing import Self

from station.bench.processes import core_s_of_family
from station.bench.service.ground import SENSOR, Ground
from station.bench.service.station_process import StationProcess, Victim
from station.bench.service.trains_by import RATE_HZ
from station.client import StationClient
from station.simulated import DeviceOptions, SimulatedCameraProcess


class Serving:
    """A station and its camera while the block runs.

    Attributes
    ----------
    port
        Where the station is called.
    client
        Calls it.
    """

    def __init__(self, ground: Ground) -> None:
        self._ground = ground
        self._camera = SimulatedCameraProcess(
            ground.address, ground.source, options=DeviceOptions(frame_rate_hz=RATE_HZ)
        )
        self._station = StationProcess(ground.folder, ground.settings, SENSOR)
        self._stack = ExitStack()
        self.port = self._station.port

    def __enter__(self) -> Self:
        with self._stack as until_failure:
            until_failure.enter_context(self._camera)
            until_failure.callback(self._station.ensure_ended)
            self._station.start()
            self._station.wait_until_ready()
            url = f"http://127.0.0.1:{self.port}"
            self.client = until_failure.enter_context(StationClient.connect(url, self._ground.key))
            self._stack = until_failure.pop_all()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stack.close()

    def core_s(self) -> dict[str, float]:
        """Return the processor seconds that each process has used by now, by its part."""
        of_recorder = self._family(Victim.RECORDER)
        return {
            "camera": core_s_of_family(self._camera.pid or 0),
            "capture": self._family(Victim.CAPTURE) - of_recorder,
            "recorder": of_recorder,
            "API": self._family(Victim.API),
            "worker and its pool": self._family(Victim.WORKER),
        }

    def _family(self, part: Victim) -> float:
        return core_s_of_family(self._station.pid_of(part) or 0)
