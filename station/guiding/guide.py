"""The way to the process that finds targets, solves on trial and draws reports."""

import os
import signal
import threading
from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures import TimeoutError as NotInTime
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from calib import CalibError
from station.documents import CalibrationDocument
from station.errors import StationError
from station.guiding.enough import Demands
from station.guiding.guidance import Guidance, guidance_of
from station.guiding.watch import SessionSoFar, SessionWatch
from station.processes.pool import pool_of_processes
from station.processes.priority import yield_to_others, yields
from station.report import calibration_report

_IDLE_S = 60.0
_PATIENCE_S = 60.0
"""Behind a train that is measured on all cores a trial solve takes long."""
_MOST_KEPT = 8
"""Sessions whose pictures are remembered, each some hundred kB."""
_Answer = TypeVar("_Answer")


class GuideLost(StationError):
    """The guiding process died over its work, or did not answer in time."""

    retry_after_s = 2


@dataclass(frozen=True, slots=True)
class _Kept:
    so_far: SessionSoFar
    present: str | None
    guidance: Guidance


class Guide:
    """Asks the guiding process; callers at the same time take turns.

    Parameters
    ----------
    idle_s
        The process ends when nobody has asked it for so long.
    patience_s
        How long an answer may take.
    """

    def __init__(self, *, idle_s: float = _IDLE_S, patience_s: float = _PATIENCE_S) -> None:
        self._idle_s, self._patience_s = idle_s, patience_s
        # One thread starts the process and stays: the process ends with the thread it came from.
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="guide")
        self._pool: ProcessPoolExecutor | None = None
        self._idle: threading.Timer | None = None
        self._kept: OrderedDict[Path, _Kept] = OrderedDict()

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
        return self._in_turn(lambda: self._guidance(watch, demands, present))

    def report(self, document: CalibrationDocument, points_csv: str, sources: list[Path]) -> str:
        """Return the printable report of a calibration, as `calibration_report`, which see.

        Raises
        ------
        StationError
            If a source cannot be used.
        GuideLost
            If the process died or did not answer in time.
        """
        return self._in_turn(lambda: self._ask(_report, document, points_csv, sources))

    @property
    def pids(self) -> list[int]:
        """Process id of the guiding process; empty where there is none."""
        pool = self._pool
        return [] if pool is None else _pids_of(pool)

    def close(self) -> None:
        """End the process; the next question starts another."""
        self._thread.submit(self._end).result()

    def _in_turn(self, work: Callable[[], _Answer]) -> _Answer:
        answer: Future[_Answer] = self._thread.submit(work)
        try:
            return answer.result(2.0 * self._patience_s)
        except NotInTime as error:
            answer.cancel()
            raise GuideLost("others were guided first; try again") from error

    def _guidance(
        self, watch: SessionWatch, demands: Demands, present: CalibrationDocument | None
    ) -> Guidance:
        kept = self._kept.get(watch.recording)
        by = None if present is None else present.fingerprint
        before = SessionSoFar() if kept is None else kept.so_far
        so_far = self._ask(_go_on, watch, before)
        if kept is None or so_far.next != before.next or kept.present != by:
            told = self._ask(_told, so_far, watch, demands, present)
            kept = _Kept(so_far, by, told)
        self._kept[watch.recording] = kept
        self._kept.move_to_end(watch.recording)
        if len(self._kept) > _MOST_KEPT:
            self._kept.popitem(last=False)
        return kept.guidance

    def _ask(self, work: Callable[..., _Answer], *given: object) -> _Answer:
        if self._pool is None:
            self._pool = pool_of_processes(1)
        self._stop_timer()
        try:
            return self._pool.submit(work, *given).result(self._patience_s)
        except BrokenProcessPool as error:
            self._end()
            raise GuideLost("the guiding process died; try again, or see the log") from error
        except NotInTime as error:
            self._end()
            raise GuideLost(f"no answer within {self._patience_s:g} s; try again") from error
        finally:
            self._idle = threading.Timer(self._idle_s, self.close)
            self._idle.daemon = True
            self._idle.start()

    def _end(self) -> None:
        self._stop_timer()
        pool, self._pool = self._pool, None
        if pool is not None:
            for pid in _pids_of(pool):
                os.kill(pid, signal.SIGKILL)  # it may hang, and has nothing to finish
            pool.shutdown(cancel_futures=True)

    def _stop_timer(self) -> None:
        if self._idle is not None:
            self._idle.cancel()
        self._idle = None


def _pids_of(pool: ProcessPoolExecutor) -> list[int]:
    # There is no public way to end a process of a pool that does not answer.
    processes = pool._processes or {}  # noqa: SLF001  see above
    return [pid for pid, each in list(processes.items()) if each.is_alive()]


def _go_on(watch: SessionWatch, so_far: SessionSoFar) -> SessionSoFar:
    _behind_others()
    return watch.go_on(so_far)


def _told(
    so_far: SessionSoFar,
    watch: SessionWatch,
    demands: Demands,
    present: CalibrationDocument | None,
) -> Guidance:
    _behind_others()
    return guidance_of(so_far, watch.target, demands, present)


def _report(document: CalibrationDocument, points_csv: str, sources: list[Path]) -> str:
    _behind_others()
    try:
        return calibration_report(document, points_csv, sources)
    except CalibError as error:  # callers here know the station's errors alone
        raise StationError(str(error)) from error


def _behind_others() -> None:
    if not yields():
        yield_to_others()
