"""The way to the process that finds targets, solves on trial, draws reports and compares."""

import threading
from collections import OrderedDict
from dataclasses import dataclass
from pathlib import Path
from typing import cast

from measure import ReadingShifts
from station.documents import CalibrationDocument
from station.errors import StationError
from station.guiding.enough import Demands
from station.guiding.guidance import Guidance
from station.guiding.watch import SessionSoFar, SessionWatch
from station.pipeline import SeenBefore
from station.processes.on_call import ProcessOnCall
from station.settings import LogLevel

_IDLE_S = 60.0
_PATIENCE_S = 60.0
"""Behind a train that is measured on all cores a trial solve takes long."""
_MOST_KEPT = 8
"""Sessions whose pictures are remembered, each some hundred kB."""


class GuideLost(StationError):
    """The guiding process died over its work, or did not answer in time."""

    retry_after_s = 2


@dataclass(frozen=True, slots=True)
class _Kept:
    so_far: SessionSoFar
    present: str | None
    guidance: Guidance


class Guide:
    """The way to the guiding process; threads that ask at the same time take turns.

    Parameters
    ----------
    level
        What the process logs.
    lock
        The file of whose lock every process of the station holds a share.
    idle_s
        The process ends by itself when nobody has asked it for so long.
    patience_s
        How long an answer may take; a process that needs longer is ended.
    """

    def __init__(
        self,
        level: LogLevel,
        lock: Path,
        *,
        idle_s: float = _IDLE_S,
        patience_s: float = _PATIENCE_S,
    ) -> None:
        self._process = ProcessOnCall("station.guiding.process", level, lock, idle_s)
        self._patience_s = patience_s
        self._turn = threading.Lock()
        self._kept: OrderedDict[Path, _Kept] = OrderedDict()

    @property
    def pid(self) -> int | None:
        """Process id of the guiding process; None where there is none."""
        return self._process.pid

    def guidance(
        self, watch: SessionWatch, demands: Demands, present: CalibrationDocument | None
    ) -> Guidance:
        """Return what to tell of a session by now; what was told already is not made again.

        Raises
        ------
        RecordingUnreadable
            If a frame is damaged.
        GuideLost
            If the process died or did not answer in time.
        """
        with self._turn:
            kept = self._kept.get(watch.recording)
            by = None if present is None else present.fingerprint
            before = SessionSoFar() if kept is None else kept.so_far
            so_far = cast(SessionSoFar, self._ask("go on", watch, before))
            if kept is None or so_far.next != before.next or kept.present != by:
                told = self._ask("guidance", so_far, watch.target, demands, present)
                kept = _Kept(so_far, by, cast(Guidance, told))
                self._keep(watch.recording, kept)
            return kept.guidance

    def report(self, document: CalibrationDocument, points_csv: str, sources: list[Path]) -> str:
        """Return the printable report of a calibration, as `calibration_report`, which see.

        Raises
        ------
        StationError
            If a source cannot be used.
        GuideLost
            If the process died or did not answer in time.
        """
        with self._turn:
            return cast(str, self._ask("report", document, points_csv, sources))

    def shifts(self, new: CalibrationDocument, seen: SeenBefore) -> ReadingShifts:
        """Return by how much readings shift with a calibration, as `shifts_with`, which see.

        Raises
        ------
        GuideLost
            If the process died or did not answer in time.
        """
        with self._turn:
            return cast(ReadingShifts, self._ask("shifts", new, seen))

    def close(self) -> None:
        """End the process; the next question starts another."""
        with self._turn:
            self._process.end()

    def _keep(self, recording: Path, kept: _Kept) -> None:
        self._kept[recording] = kept
        self._kept.move_to_end(recording)
        if len(self._kept) > _MOST_KEPT:
            self._kept.popitem(last=False)

    def _ask(self, work: str, *given: object) -> object:
        try:
            link = self._process.link()
            link.send((work, given))
            if not link.poll(self._patience_s):
                self._process.end()
                raise GuideLost(f"no answer within {self._patience_s:g} s; try again")
            answer, error = cast(tuple[object, StationError | None], link.recv())
        except (EOFError, OSError) as gone:
            self._process.end()
            raise GuideLost("the guiding process died; try again, or see the log") from gone
        if error is not None:
            raise error
        return answer
