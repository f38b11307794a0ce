"""A station beside the track whose API process can die: what its sensors did is in true logs.

The doubles of the capture processes write files, outlive the API, and refuse what the real ones
refuse; a file is as many lines as frames.
"""

import asyncio
from dataclasses import dataclass, field
from pathlib import Path

import httpx
from mortal import Died, Life, mortal
from served_station import ADMIN_KEY, Served

from station.api import build_app
from station.capture import CaptureReport, CaptureState, CaptureStatus
from station.errors import CameraUnreachable, InputUnusable, StateConflict
from station.operations import Lifetimes, Passes, Salvaged, Sessions
from station.recording import active_path, left_behind, part_path


@dataclass
class TrueCapture:
    """The capture process of one sensor, and a log of what it did."""

    sensor: str
    plan: object = None
    reachable: bool = True
    filled: list[Path] = field(default_factory=list)
    """Every file that a first frame went into, in order."""
    refused: list[Path] = field(default_factory=list)
    """Every recording that was to begin while another one ran."""
    unheard: set[Path] = field(default_factory=set)
    """Recordings that were to be closed while they ran and nobody could say so."""

    def status(self):
        self._ensure_reachable()
        plan = self.plan
        return CaptureStatus(
            CaptureState.RECORDING if plan else CaptureState.IDLE,
            self.sensor,
            session_id=plan.session_id if plan else None,
            path=plan.path if plan else None,
            recorded=self.frames,
        )

    def arm(self, plan):
        self._ensure_reachable()
        if self.plan is not None:
            self.refused.append(plan.path)
            raise StateConflict("a recording runs already", state="recording")
        file = file_of(plan)
        if file.exists() or active_path(file).exists():
            raise InputUnusable(f"{file} exists; recordings are not overwritten")
        active_path(file).touch(exist_ok=False)
        self.plan = plan

    def trigger(self):
        self._ensure_reachable()
        if self.plan is None:
            raise StateConflict("nothing is recorded", state="idle")
        self.wheel()
        return self.frames

    def finish(self, expected_frames=None):
        if self.plan is not None and not self.reachable:
            self.unheard.add(self.plan.path)
        self._ensure_reachable()
        if self.plan is None:
            raise StateConflict("nothing is recorded", state="idle")
        plan, self.plan = self.plan, None
        active_path(file_of(plan)).rename(file_of(plan))
        path, before = plan.path, plan.goes_on
        frames = frames_of(path)
        numbered = 0 if before is None else before.frames
        assert frames >= numbered, "told of more frames than there are"
        back = () if before is None else (before.event(1),)
        return CaptureReport(
            path=path,
            triggered=expected_frames,
            recorded=frames,
            lost=0 if expected_frames is None else max(expected_frames - frames, 0),
            refused=0,
            repeated=0,
            resent_packets=0,
            first_time_ns=None,
            last_time_ns=None,
            paths=tuple(files_of(path)),
            events=back,
        )

    @property
    def frames(self) -> int:
        return 0 if self.plan is None else frames_in(active_path(file_of(self.plan)))

    def wheel(self) -> None:
        """Something comes before the camera: a frame, where it records."""
        if self.plan is not None:
            if not self.frames:
                self.filled.append(file_of(self.plan))
            with active_path(file_of(self.plan)).open("a") as file:
                file.write("frame\n")

    def die(self) -> None:
        """End and be started again: what was recorded is left under its active name."""
        self.plan = None

    def _ensure_reachable(self):
        if not self.reachable:
            raise CameraUnreachable(f"sensor {self.sensor}: no camera answers")


def frames_in(file: Path) -> int:
    """How many frames a file of the doubles holds."""
    return len(file.read_text().splitlines())


def file_of(plan) -> Path:
    """The file that a plan writes first: that of the recording, or the next where it goes on."""
    return part_path(plan.path, 1 if plan.goes_on is None else plan.goes_on.files + 1)


def files_of(path: Path) -> list[Path]:
    """The files of a recording as they are called now."""
    parts = [part for _, part in left_behind(path)]
    return [active_path(part) if active_path(part).exists() else part for part in parts]


def frames_of(path: Path) -> int:
    """How many frames a recording of the doubles holds."""
    return sum(frames_in(file) for file in files_of(path))


class Trackside(Served):
    """A served station with true captures, whose API process dies and is started again."""

    def __init__(self, root, empty_store, **settings):
        self.life = Life()
        super().__init__(root, empty_store, **settings)

    def _capture(self, sensor):
        return TrueCapture(sensor.id)

    def _station_of_process(self):
        return mortal(self.station, self.life)

    def _salvage(self, path):
        files = files_of(path)
        if not files:
            return None
        last = part_path(path, len(files))
        if active_path(last).exists():
            if any(each.plan and each.plan.path == path for each in self.captures.values()):
                raise StateConflict(f"{path} is still being written; is its disk stuck?")
            active_path(last).rename(last)
        frames = frames_of(path)
        return Salvaged(
            frames,
            f"{frames} frames saved",
            files=len(files),
            interruptions=len(files) - 1,
            last_frame_id=frames or None,
            last_frame_ns=1 if frames else None,
        )

    def look(self) -> None:
        """Have the API process look at what goes on, as it does about once a second."""
        parts = self.app.state.parts
        Lifetimes(parts.station, parts.passes, parts.sessions).look()

    def kill_and_begin_again(self, deeds_while_starting: int | None = None) -> None:
        """Kill the API process and start the next; that one may die while it takes things up."""
        self.life.end_after(0)
        self.end()
        if deeds_while_starting is not None:
            self._take_up(deeds_while_starting)
        self._take_up(None)
        self.begin()

    def _take_up(self, deeds: int | None) -> None:
        """Do what an API process does before it serves."""
        self.life = Life()
        if deeds is not None:
            self.life.end_after(deeds)
        try:
            Passes(self._station_of_process()).take_up()
            Sessions(self._station_of_process()).take_up()
        except Died:
            return


class InProcess(Trackside):
    """A station beside the track whose API is called without a network, which is quicker."""

    def begin(self) -> None:
        self.app = build_app(
            self._station_of_process(), admin_key=ADMIN_KEY, worker_ready=lambda: True
        )

    def end(self) -> None:
        self.life.end_after(0)

    def request(self, method, path, **given) -> httpx.Response:
        """Make a call; raises `Died` where the API process dies of it."""

        async def one():
            transport = httpx.ASGITransport(self.app)
            headers = {"Authorization": f"Bearer {ADMIN_KEY}", **given.pop("headers", {})}
            async with httpx.AsyncClient(transport=transport, base_url="http://station") as client:
                return await client.request(method, path, headers=headers, **given)

        return asyncio.run(one())
