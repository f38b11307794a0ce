"""Counting frames by their ids: what was recorded, lost, refused, repeated.

The driver's own counters hide loss: a receiver that slept for a second lost sixteen frames with
every buffer's status a success.  Only the ids tell.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

from station.capture.interruption import Interruption
from station.recording import Event, EventKind, id_after, ids_skipped

_PLAUSIBLE_FIRST_LOSS = 1000
"""A first id up to here is a loss at the start; beyond, a counter that began before."""


@dataclass(slots=True)
class FrameAccount:
    """The account of one recording; every difference becomes an event.

    `recorded` counts what the recorder has confirmed, the rest what was seen to arrive.
    """

    now_ns: Callable[[], int]
    note: Callable[[Event], None]
    """Takes each event as it happens."""
    arrived: int = 0
    """Frames that arrived whole and in order."""
    recorded: int = 0
    lost: int = 0
    refused: int = 0
    repeated: int = 0
    earlier: int = 0
    """Frames that a capture process which is gone had recorded; not in `arrived`, `recorded`."""
    _last_id: int | None = field(default=None, init=False)
    _before: int = field(default=0, init=False)
    _dropped: list[int] = field(default_factory=list, init=False)

    @property
    def accounted(self) -> int:
        """Frames whose fate is known, or that are on their way to the disk."""
        return self.earlier + self.arrived + self.lost + self.refused

    def arrive(self, frame_id: int | None, flaw: str | None) -> bool:
        """Take a frame into account; return whether it is to be recorded.

        Parameters
        ----------
        frame_id
            As the camera numbers them; None where the packet that says it is lost.  Such a frame
            is said in an event and counted when the next id shows that one is missing.
        flaw
            Why the frame is incomplete; None where it is whole.
        """
        if frame_id is None:
            self._say(EventKind.FRAME_REFUSED, None, 0, f"{flaw}, id unknown: counted as lost")
            return False
        number, skipped = self.number(frame_id), self._skipped(frame_id)
        if skipped is None:
            self.repeated += 1
            self._say(EventKind.FRAME_REPEATED, number, 1, f"after frame {self._last_number}")
            return False
        if skipped:
            self.lost += skipped
            first = 1 if self._last_id is None else id_after(self._last_id)
            self._say(EventKind.FRAMES_LOST, self.number(first), skipped, f"before frame {number}")
        self._last_id = frame_id
        if flaw is not None:
            self.refused += 1
            self._say(EventKind.FRAME_REFUSED, number, 1, flaw)
            return False
        self.arrived += 1
        return True

    def confirm(self) -> None:
        """Note that a frame that arrived is in the file."""
        self.recorded += 1

    def drop(self, frame_id: int) -> None:
        """Note that a frame could not be written; `close` says so, once for all of them."""
        self.arrived -= 1
        self.lost += 1
        self._dropped.append(frame_id)

    def retract(self, count: int) -> None:
        """Note that so many recorded frames are not in the file after all."""
        self.arrived -= count
        self.recorded -= count
        self.lost += count

    def number(self, frame_id: int) -> int:
        """Return the number of a frame in the recording, where no two frames have the same.

        It is the camera's id; that of a camera which was opened again goes on behind the last one.
        """
        if not self._before:
            return frame_id
        # By the larger one it is told whether ids have 16 bits, and begin again, or 64.
        return id_after(max(frame_id, self._before), min(frame_id, self._before))

    def begin_again(self) -> None:
        """Expect the ids of a camera that was opened again: they begin anew."""
        self._before, self._last_id = self._last_number, None

    def go_on(self, interruption: Interruption) -> None:
        """Take frames into account that are there already; expect ids that begin anew."""
        self.earlier, self._before = interruption.frames, interruption.last_frame_id

    @property
    def _last_number(self) -> int:
        return self._before if self._last_id is None else self.number(self._last_id)

    def close(self, triggered: int | None) -> None:
        """Say what could not be written; compare with the exposures somebody else counted."""
        if self._dropped:
            count = len(self._dropped)
            self._say(EventKind.FRAMES_DROPPED, self._dropped[0], count, "could not be written")
        if triggered is None or triggered == self.accounted:
            return
        if triggered > self.accounted:
            missing = triggered - self.accounted
            self.lost += missing
            detail = f"{triggered} triggered, {missing} of them without a trace"
            self._say(EventKind.FRAMES_MISCOUNTED, None, missing, detail)
        else:
            detail = f"{triggered} triggered, {self.accounted} frames came"
            self._say(EventKind.FRAMES_MISCOUNTED, None, 0, detail)

    def _skipped(self, frame_id: int) -> int | None:
        if self._last_id is not None:
            return ids_skipped(self._last_id, frame_id)
        # GigE Vision: the first block of a stream that was just opened is 1.
        if frame_id - 1 <= _PLAUSIBLE_FIRST_LOSS:
            return frame_id - 1
        number = self.number(frame_id)
        self._say(EventKind.COUNTER_OFFSET, number, 0, "a loss before it cannot be told")
        return 0

    def _say(self, kind: EventKind, frame_id: int | None, count: int, detail: str) -> None:
        self.note(Event(kind, self.now_ns(), detail, frame_id, count))
