"""`station serve` as a process of its own, whose processes are found, killed and counted."""

import contextlib
import json
import os
import secrets
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from enum import StrEnum
from pathlib import Path

from station.bench.processes import children_of, has_ended, parent_of
from station.client import StationClient
from station.errors import StationError
from station.operations import DataLayout
from station.processes.port import port_for_later

PATIENCE_S = 120.0
_LOOK_S = 0.02


class Victim(StrEnum):
    """A process of the station."""

    API = "api"
    CAPTURE = "capture"
    RECORDER = "recorder"
    WORKER = "worker"
    SUPERVISOR = "supervisor"


class StationProcess:
    """A station on a folder of its own; started again as often as is wanted.

    Parameters
    ----------
    folder
        Takes data, log and sockets.
    settings
        The settings file but `data_dir` and `port`.
    sensor
        Its one sensor.
    store_url
        Its database, where that is no file in the folder.
    """

    def __init__(
        self, folder: Path, settings: str, sensor: str, *, store_url: str | None = None
    ) -> None:
        self.layout = DataLayout(folder / "data", store_url)
        self.key = secrets.token_urlsafe(32)
        self._port = port_for_later()
        self._folder = folder
        self._sensor = sensor
        self._log = folder / "station.log"
        self._config = folder / "station.toml"
        # A station that is started again is found where it was.
        head = f'data_dir = "{self.layout.root}"\nport = {self._port}\n'
        head += "" if store_url is None else f'store_url = "{store_url}"\n'
        self._config.write_text(head + settings, encoding="utf-8")
        self._process: subprocess.Popen[bytes] | None = None

    @property
    def port(self) -> int:
        """Where its API listens."""
        return self._port

    @property
    def url(self) -> str:
        """Where its API is, also after it was started again."""
        return f"http://127.0.0.1:{self._port}"

    @property
    def pid(self) -> int:
        """Process id of the supervisor."""
        return 0 if self._process is None else self._process.pid

    def start(self) -> None:
        """Start the station; it needs seconds to be ready."""
        inherited = {k: v for k, v in os.environ.items() if not k.startswith("STATION_")}
        own = {"STATION_ADMIN_KEY": self.key, "TMPDIR": str(self._folder)}
        with self._log.open("ab") as log:
            self._process = subprocess.Popen(  # noqa: S603  our own interpreter and module
                [sys.executable, "-m", "station", "serve", "--config", str(self._config)],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                env=inherited | own,
            )

    def ask_to_end(self, *, all_at_once: bool = False) -> None:
        """Send SIGTERM to the supervisor, or to all processes as a service manager does."""
        for pid in self.processes() if all_at_once else {self.pid}:
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGTERM)

    def wait_for_end(self) -> int:
        """Return the supervisor's exit code once it has ended."""
        return 0 if self._process is None else self._process.wait(PATIENCE_S)

    def ensure_ended(self) -> None:
        """End the station, by force where it does not; safe to call twice."""
        if self._process is None:
            return
        self.ask_to_end()
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.wait_for_end()
        for pid in self.processes():
            with contextlib.suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        self._process.wait()

    @contextmanager
    def client(self) -> Generator[StationClient]:
        """Open a connection to the station's API."""
        with StationClient.connect(self.url, self.key) as client:
            yield client

    def wait_until_ready(self) -> None:
        """Wait until every part is ready; StationError where that takes too long."""
        with self.client() as client:
            self.wait(client.ready, "to be ready")

    def wait(self, reached: Callable[[], bool], what: str) -> None:
        """Wait for something; StationError with the log's last lines where it does not come."""
        until_s = time.monotonic() + PATIENCE_S
        while not reached():
            if time.monotonic() > until_s:
                said = self._log.read_text(errors="replace").splitlines()[-10:]
                raise StationError("\n".join([f"waited {PATIENCE_S:g} s {what}; log:", *said]))
            time.sleep(_LOOK_S)

    def pid_of(self, victim: Victim) -> int | None:
        """Return the process id of a part that runs; None where it does not at the moment."""
        if victim is Victim.SUPERVISOR:
            return self.pid
        if victim is Victim.RECORDER:
            capture = self.pid_of(Victim.CAPTURE)
            found = [] if capture is None else _running_children(capture)
            return found[-1] if found else None
        child = f"capture {self._sensor}" if victim is Victim.CAPTURE else victim.value
        pid = self._last_started(child)
        return None if pid is None or has_ended(pid) else pid

    def kill(self, victim: Victim) -> None:
        """Kill a process of the station by SIGKILL, as soon as it runs."""
        self.wait(lambda: self.pid_of(victim) is not None, f"for the {victim} to run")
        os.kill(self.pid_of(victim) or 0, signal.SIGKILL)
        if victim is Victim.SUPERVISOR:
            self.wait_for_end()

    def processes(self) -> set[int]:
        """Return all processes that the station ever started and that still run."""
        mark = f"TMPDIR={self._folder}\0".encode()
        found = set()
        for path in Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):
                if mark in (path / "environ").read_bytes() and not has_ended(int(path.name)):
                    found.add(int(path.name))
        return found

    def orphans(self) -> set[int]:
        """Return those of them that do not descend from the present supervisor."""
        return {pid for pid in self.processes() if not _descends(pid, self.pid)}

    def folders_of_sockets(self) -> list[Path]:
        """Return the folders that stations made for their sockets and did not remove."""
        return sorted(path for path in self._folder.glob("treadline-*") if path.is_dir())

    def _last_started(self, child: str) -> int | None:
        found = None
        for line in self._log.read_text(errors="replace").splitlines():
            if '"started"' in line and f'"{child}"' in line:
                found = int(json.loads(line)["pid"])
        return found


def _running_children(pid: int) -> list[int]:
    with contextlib.suppress(FileNotFoundError, ProcessLookupError):
        return [child for child in children_of(pid) if not has_ended(child)]
    return []


def _descends(pid: int, ancestor: int) -> bool:
    while pid > 1:
        if pid == ancestor:
            return True
        try:
            pid = parent_of(pid)
        except (FileNotFoundError, ProcessLookupError):
            return True  # it has ended meanwhile
    return False
