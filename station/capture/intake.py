"""Frames on their way from the camera through the ring to the recorder, each accounted for."""

import contextlib
import time
from collections.abc import Callable, Iterable, Mapping

from station.capture.accounting import FrameAccount
from station.capture.clock import CameraClock, ClockSample
from station.capture.link import Entry, FrameEntry, Outcome, RecorderDied, RecorderLink
from station.capture.stream import FrameStream, ReceivedFrame
from station.errors import DiskFull, RecordingError, StationError
from station.recording import Event, EventKind

_POP_TIMEOUT_US = 4_000
"""Orders, as for the status, wait for so long at most, and readers of `/v1/station` with them."""
_UNDERRUN_INTERVAL_S = 1.0
_MOST_RESTARTS = 10


class Intake:
    """Takes frames off a stream, hands them to the recorder, and lends their slots again.

    Parameters
    ----------
    link
        The recorder, with the recording open.
    slots
        The ring's slots, all free.
    limit
        Frames beyond so many are surplus: not recorded, not accounted.
    exposure_of
        How a frame was taken, by its id, where that is to be recorded with it.
    """

    def __init__(
        self,
        link: RecorderLink,
        slots: Iterable[int],
        limit: int | None,
        exposure_of: Callable[[int], Mapping[str, float] | None] = lambda _: None,
    ) -> None:
        self.account = FrameAccount(time.time_ns, self.note)
        self.events: list[Event] = []
        self.resent_packets = 0
        self.first_time_ns: int | None = None
        self.last_time_ns: int | None = None
        self.last_recorded_id: int | None = None
        self.heard_s = time.monotonic()
        """When the last frame came, or the camera was opened."""
        self.frame_s: float | None = None
        """When the last frame came."""
        self.failure: StationError | None = None
        """Why nothing more is written."""
        self.receiving: dict[str, str] = {}
        """How packets are received."""
        self._link = link
        self._limit = limit
        self._exposure_of = exposure_of
        self._free = set(slots)
        self._stream: FrameStream | None = None
        self.clock = CameraClock(0)
        """The clock of the camera attached."""
        self._underruns = 0
        self._underruns_asked_s = 0.0
        self._restarts = 0

    @property
    def free_slots(self) -> frozenset[int]:
        """Slots that hold nothing and are not lent to the driver."""
        return frozenset(self._free)

    @property
    def in_flight(self) -> bool:
        """Whether a frame is being received."""
        return self._stream is not None and self._stream.in_flight

    @property
    def unwritten(self) -> int:
        """Entries that the recorder has not yet answered."""
        return self._link.pending

    def attach(self, stream: FrameStream, clock: CameraClock) -> None:
        """Take frames from a stream that all free slots were lent to."""
        self._stream, self.clock = stream, clock
        self.receiving = {
            "receive_method": stream.method,
            "receive_buffer_bytes": str(stream.buffer_bytes),
        }
        self._underruns = 0
        self._free.clear()
        self.heard_s = time.monotonic()

    def detach(self, *, lost: bool) -> None:
        """Take the last frames, then close the stream of a camera that is there or `lost`."""
        if self._stream is None:
            return
        self.resent_packets += self._stream.resent_packets
        self._note_underruns()
        stream, self._stream = self._stream, None
        lent = stream.lent
        last = stream.close(lost=lost)
        self._free |= lent - {frame.slot for frame in last}
        for frame in last:
            self._take(frame)

    def step(self) -> None:
        """Take what has come, waiting a few milliseconds at most; see what was written."""
        if self._stream is not None:
            for frame in self._stream.take(_POP_TIMEOUT_US):
                self._take(frame)
            if time.monotonic() - self._underruns_asked_s > _UNDERRUN_INTERVAL_S:
                self._note_underruns()
        self.settle()

    def settle(self, timeout_s: float = 0.0) -> None:
        """Take note of what the recorder has answered."""
        try:
            for outcome in self._link.outcomes(timeout_s):
                self._settle(outcome)
        except RecorderDied:
            self.revive()

    def note(self, event: Event) -> None:
        """Put an event into the report and the file."""
        self.events.append(event)
        self._put(event)

    def _take(self, frame: ReceivedFrame) -> None:
        self.heard_s = self.frame_s = time.monotonic()
        surplus = self._limit is not None and self.account.accounted >= self._limit
        wanted = not surplus and self.account.arrive(frame.frame_id, frame.flaw)
        if not wanted or frame.frame_id is None:
            self._give_back(frame.slot)
            return
        number = self.account.number(frame.frame_id)
        utc_ns = self.clock.utc_ns(frame.camera_ns, frame.received_ns)
        self._put(
            FrameEntry(
                slot=frame.slot,
                frame_id=number,
                camera_time_ns=utc_ns,
                host_time_ns=frame.received_ns,
                width=frame.width,
                height=frame.height,
            )
        )
        values = self._exposure_of(frame.frame_id)
        if values is not None:
            # Behind its frame, never before: a recording may go on in a next file between them.
            self._put(Event(EventKind.EXPOSED, frame.received_ns, "", number, 1, values))

    def learn_time(self, sample: ClockSample) -> None:
        """Take what the camera's clock showed; a clock that was set anew is said."""
        jumps = self.clock.jumps
        self.clock.learn(sample)
        if self.clock.jumps > jumps:
            detail = f"the camera's clock is now {-sample.offset_ns / 1e9:.6f} s ahead of UTC"
            self.note(Event(EventKind.CLOCK_SET, time.time_ns(), detail))

    def packets_resent(self) -> int:
        """Return how many packets came on request so far."""
        now = 0 if self._stream is None else self._stream.resent_packets
        return self.resent_packets + now

    def _put(self, entry: Entry) -> None:
        if self.failure is not None:
            self._settle(Outcome(entry, self.failure))
            return
        try:
            self._link.put(entry)
        except RecorderDied:
            self.revive()

    def _settle(self, outcome: Outcome) -> None:
        if outcome.failure is not None:
            self.fail(outcome.failure)
        if not isinstance(outcome.entry, FrameEntry):
            return
        self._give_back(outcome.entry.slot)
        if outcome.failure is not None:
            self.account.drop(outcome.entry.frame_id)
            return
        self.account.confirm()
        self.last_recorded_id = outcome.entry.frame_id
        self.last_time_ns = outcome.entry.camera_time_ns
        self.first_time_ns = self.first_time_ns or self.last_time_ns

    def _give_back(self, slot: int) -> None:
        if self._stream is None:
            self._free.add(slot)
        else:
            self._stream.lend(slot)

    def revive(self) -> None:
        """Let another recorder go on with the file; what it must still write lies in the ring."""
        try:
            outcomes = self._restarted()
        except StationError as error:
            self.fail(error)
            for entry in self._link.abandon():
                self._settle(Outcome(entry, error))
            return
        for outcome in outcomes:
            self._settle(outcome)
        detail = "the recorder died; another goes on with its file"
        self.note(Event(EventKind.RECORDER_RESTARTED, time.time_ns(), detail))

    def _restarted(self) -> tuple[Outcome, ...]:
        while self._restarts < _MOST_RESTARTS:
            self._restarts += 1
            with contextlib.suppress(RecorderDied):
                return self._link.restart()
        raise RecordingError(f"the recorder died {_MOST_RESTARTS} times; see the system's log")

    def fail(self, failure: StationError) -> None:
        """Write nothing more, and say so once, in the report: the file cannot hold it."""
        if self.failure is not None:
            return
        self.failure = failure
        kind = EventKind.DISK_FULL if isinstance(failure, DiskFull) else EventKind.RECORDER_FAILED
        self.events.append(Event(kind, time.time_ns(), str(failure)))

    def compare(self, frames: int) -> None:
        """Take into account that the file holds fewer frames than were said to be written."""
        missing = self.account.earlier + self.account.recorded - frames
        if missing > 0:
            self.account.retract(missing)
            detail = "given up for the end of the file, the disk being full"
            event = Event(EventKind.FRAMES_DROPPED, time.time_ns(), detail, count=missing)
            self.events.append(event)

    def _note_underruns(self) -> None:
        if self._stream is None:
            return
        self._underruns_asked_s = time.monotonic()
        new = self._stream.underruns - self._underruns
        if new > 0:
            self._underruns += new
            detail = f"{new} packets met no free slot between camera and disk"
            self.note(Event(EventKind.RING_FULL, time.time_ns(), detail))
