"""What a process does for a replay, be it this one or one on another machine."""

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path

from station.documents import MeasurementDocument
from station.errors import StationError
from station.pipeline import Cores
from station.processes.one_core import use_one_core
from station.replay.forms import Form
from station.replay.means import unpacked
from station.replay.measuring import Files, Measuring
from station.replay.passes import Lookers
from station.replay.remote import fetched
from station.replay.report import Refusal
from station.replay.task import ReplayTask, Token
from station.software import SOFTWARE


class OtherSoftware(StationError):
    """A worker runs another version: its readings need not be those of this one."""


@dataclass(frozen=True, slots=True)
class Order:
    """One task, and all that a worker must know to do it."""

    task: ReplayTask
    means: bytes
    form: Form
    software: str = SOFTWARE


@dataclass(frozen=True, slots=True)
class Answer:
    """What came of a task.

    Attributes
    ----------
    content
        The wheels, as the content of a part.
    held
        The recordings that they are of; none where nothing may be used.
    refused
        The other recordings, and why.
    frames
        Frames that were read.
    """

    content: bytes
    held: frozenset[Token]
    refused: tuple[Refusal, ...]
    frames: int


@dataclass(frozen=True, slots=True, eq=False)
class Doing:
    """How tasks are done, with what.

    Attributes
    ----------
    frames_done
        Called with the number of frames of a task that have been read.
    """

    lookers: Lookers
    heading: MeasurementDocument
    form: Form
    max_skew_us: dict[str, float]
    cores: Cores = field(default_factory=lambda: Cores(None))
    frames_done: Callable[[int], None] = lambda _count: None

    def do(self, task: ReplayTask) -> Answer:
        """Measure what a task names; remote files are copied, for as long as it takes."""
        with tempfile.TemporaryDirectory(prefix="treadline-fetched-") as folder:
            try:
                files = _fetched(task, Path(folder))
            except StationError as error:
                refused = tuple(Refusal(one.name, str(error)) for one in task.recordings)
                return Answer(b"", frozenset(), refused, 0)
            return self._measured(task, files)

    def _measured(self, task: ReplayTask, files: Files) -> Answer:
        measuring = Measuring(
            self.lookers, self.cores, max_skew_us=self.max_skew_us, frames_done=self.frames_done
        )
        wheels = measuring.wheels(task, files)
        if task.sensors:
            # Which recordings were sound is known at the end; the wheels of a pass are in memory.
            every = tuple(wheels)
            wheels = (wheel for wheel in every if wheel.source not in measuring.refused)
        content = self.form.encoded(self.heading, wheels)
        sound = [one.token for one in task.recordings if one.name not in measuring.refused]
        refused = tuple(Refusal(name, why) for name, why in measuring.refused.items())
        return Answer(content, frozenset(sound), refused, measuring.frames)


def do_order(order: Order) -> Answer:
    """Do a task as a worker.

    Raises
    ------
    OtherSoftware
        If this is another version than the one that gave the order.
    """
    be_a_worker(order.software)
    means, lookers = unpacked(order.means)
    doing = Doing(lookers, means.heading(lookers), order.form, dict(means.max_skew_us))
    return doing.do(order.task)


def be_a_worker(software: str) -> None:
    """Prepare this process for what another one gives it to do.

    Raises
    ------
    OtherSoftware
        If this is another version than that one's.
    """
    if software != SOFTWARE:
        raise OtherSoftware(
            f"a worker runs {SOFTWARE} and this is {software}; install the same on all"
        )
    _work_on_one_core()


@lru_cache(maxsize=1)
def _work_on_one_core() -> None:
    use_one_core()


def _fetched(task: ReplayTask, folder: Path) -> dict[str, Sequence[Path]]:
    files: dict[str, Sequence[Path]] = {}
    for place, recording in enumerate(task.recordings):
        own = folder / str(place)
        own.mkdir()
        files[recording.name] = fetched(recording.addresses, own)
    return files
