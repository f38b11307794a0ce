"""Trains that were recorded before and wait to be measured: there is always a next one."""

import threading
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Self

from sqlalchemy.orm import Session

from station.operations import DataLayout, utc_now
from station.store import (
    JobKind,
    Pass,
    PassState,
    Recording,
    Store,
    add_job,
    unfinished_jobs,
)

_LOOK_S = 0.5
_AHEAD = 2


@dataclass(frozen=True, slots=True)
class RecordedTrain:
    """One file, which all trains that wait share.

    Attributes
    ----------
    path
        Relative to the folder of the station's data.
    """

    path: Path
    frames: int
    sensor: str
    calibration: str


@dataclass(slots=True)
class TrainsWaiting:
    """While the block runs, a train is being measured and another waits."""

    layout: DataLayout
    train: RecordedTrain
    added: int = field(default=0, init=False)
    measured: int = field(default=0, init=False)
    """Trains that were measured by the end of the block."""
    _enough: threading.Event = field(default_factory=threading.Event, init=False)
    _thread: threading.Thread = field(init=False)

    @staticmethod
    def job_of(number: int) -> str:
        """Return the id of the job that measures a train, by its number from 0."""
        return f"job-waiting-{number:03}"

    def __enter__(self) -> Self:
        self._thread = threading.Thread(target=self._keep_waiting, name="trains", daemon=True)
        store = Store.open(self.layout.store_url)
        self._see_to(store)  # the first is there when the block begins
        store.close()
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._enough.set()
        self._thread.join()

    def _keep_waiting(self) -> None:
        store = Store.open(self.layout.store_url)
        while not self._enough.wait(_LOOK_S):
            self._see_to(store)
        store.close()

    def _see_to(self, store: Store) -> None:
        with store.look() as session:
            waiting = sum(job.kind == JobKind.MEASURE for job in unfinished_jobs(session))
        self.measured = self.added - waiting
        for _ in range(_AHEAD - waiting):
            with store.change() as session:
                self._add(session, self.added)
            self.added += 1

    def _add(self, session: Session, number: int) -> None:
        now, name, job_id = utc_now(), f"waiting-{number:03}", self.job_of(number)
        session.add(
            Pass(id=name, state=PassState.MEASURING, opened_at=now, finished_at=now, job_id=job_id)
        )
        session.flush()
        session.add(
            Recording(
                id=f"pass.{name}.{self.train.sensor}",
                sensor=self.train.sensor,
                pass_id=name,
                path=str(self.train.path),
                opened_at=now,
                closed_at=now,
                calibration_id=self.train.calibration,
                recorded=self.train.frames,
                lost=0,
                repeated=0,
                refused=0,
                complete=True,
                recovered=False,
                files=1,
                summary="recorded before",
            )
        )
        add_job(session, job_id, JobKind.MEASURE, name, at=now)
