"""Recordings that are measured together while they are written: a sensor's, or those of a rig."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from station.documents import WheelDocument
from station.errors import RecordingUnreadable, StationError
from station.pipeline import Looker, Resumption, WheelFollower
from station.recording import GrowingRecording
from station.store import Measurement, Pass, PassState, Recording, the
from station.store.measured import keep_followed, note_followed
from station.worker.context import WorkContext
from station.worker.resuming import Means, to_note
from station.worker.rows import measurement_row, recording_of

QUIET_S = 0.2
"""With no frame for so long a wheel is taken to be over: five times what parts two wheels, and more
than a frame takes from the camera to the disk."""
_FRAMES_A_TURN = 4
_FEW_TURNS = 8
"""To complete a pass in: where more is left, the job has all cores for it."""
_MOST_WAITING = 512
"""Frames of one sensor that wait for the other's; a stripe is some 100 kB."""


_STILL_OURS = frozenset({PassState.RECORDING, PassState.RECORDED, PassState.MEASURING})
"""The job that measures has the pass let go of before it begins, and nothing is kept after that."""


class PassOver(StationError):
    """The pass has ended otherwise, and nothing more is to be kept of it."""


@dataclass(frozen=True, slots=True)
class Together:
    """What is measured together, with what, and from where on.

    Attributes
    ----------
    recordings
        By sensor; those that the looker takes frames of.
    """

    pass_id: str
    recordings: Mapping[str, Recording]
    looker: Looker
    means: Means
    since: Resumption


class FollowedRecordings:
    """The recordings of one looker: each turn takes what has come and keeps what is known by it."""

    def __init__(
        self,
        context: WorkContext,
        together: Together,
        clock_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._context, self._together, self._clock_s = context, together, clock_s
        names = {sensor: Path(each.path).name for sensor, each in together.recordings.items()}
        self._by_file = {names[sensor]: each for sensor, each in together.recordings.items()}
        self._growing = {
            sensor: GrowingRecording(context.layout.root / each.path, together.since.of(sensor))
            for sensor, each in together.recordings.items()
        }
        self._follower = WheelFollower(together.looker, names, together.since)
        self._early: list[WheelDocument] = []
        self._last_s: float | None = None
        self.wheels, self.withdrawn, self.behind_s = 0, 0, 0.0
        """Wheels kept for certain, early readings withdrawn, and how far it was behind at most."""

    def turn(self) -> bool:
        """Take the next frames and keep the wheels they tell of; False where none had come.

        Raises
        ------
        PassOver
            If nothing more is to be kept of the pass.
        StationError
            If the recordings cannot be followed.
        """
        over: list[WheelDocument] = []
        taken = 0
        for sensor, growing in self._growing.items():
            frames = growing.read(_FRAMES_A_TURN)
            if frames:
                over += self._follower.take(sensor, frames)
                self._note_behind(frames[-1][1].host_time_ns)
                taken += len(frames)
        self._ensure_few_waiting()
        if over:
            self._keep(over, self._early_after(over))
        if taken:
            self._last_s = self._clock_s()
        elif self._last_s is not None and self._clock_s() - self._last_s >= QUIET_S:
            self._last_s = None
            self._keep([], self._follower.open_wheels())
        return taken > 0

    def complete(self) -> None:
        """Take what is left of recordings that have ended, where it is little; then it is all kept.

        Raises
        ------
        PassOver
            If nothing more is to be kept of the pass.
        StationError
            If the recordings cannot be followed.
        """
        for _ in range(_FEW_TURNS):
            if not self.turn():
                break
        ends = {sensor: growing.end for sensor, growing in self._growing.items()}
        places = {sensor: place for sensor, place in ends.items() if place is not None}
        if len(places) == len(ends):
            self._keep(list(self._follower.end(places)), [])

    def close(self) -> None:
        """Close the files."""
        for growing in self._growing.values():
            growing.close()

    def _early_after(self, over: Sequence[WheelDocument]) -> list[WheelDocument]:
        """Return the early readings that stand beside the wheels now over."""
        agreed = self._early[: len(over)] == list(over)[: len(self._early)]
        return self._early[len(over) :] if agreed else []

    def _ensure_few_waiting(self) -> None:
        waiting = self._follower.frames_waiting
        if waiting > _MOST_WAITING:
            sensors = ", ".join(self._growing)
            raise RecordingUnreadable(
                f"{waiting} frames of {sensors} wait for frames of another sensor; they are "
                "measured when the pass is finished"
            )

    def _note_behind(self, host_time_ns: int) -> None:
        behind_s = self._context.now().timestamp() - host_time_ns / 1e9
        self.behind_s = max(self.behind_s, behind_s)

    def _keep(self, over: Sequence[WheelDocument], early: Sequence[WheelDocument]) -> None:
        together = self._together
        certain, uncertain = self._rows(over), self._rows(early)
        with self._context.store.change() as session:
            state = the(session, Pass, together.pass_id).state
            if state not in _STILL_OURS:
                raise PassOver(f"pass {together.pass_id} is {state}")
            ids = [each.id for each in together.recordings.values()]
            withdrawn = keep_followed(session, ids, certain, uncertain)
            notes = to_note(together.means, together.recordings, self._follower.resumption)
            note_followed(session, notes)
        self._early = list(early)
        self.wheels += len(over)
        self.withdrawn += withdrawn

    def _rows(self, wheels: Sequence[WheelDocument]) -> list[Measurement]:
        found = self._together.looker.document(wheels)
        return [
            measurement_row(
                self._context, recording_of(wheel, self._by_file), wheel, place=at, found=found
            )
            for at, wheel in enumerate(wheels)
        ]
