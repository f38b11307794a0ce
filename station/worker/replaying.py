"""The job that measures recordings once more: a recording a step, or those of a rig together.

Where many are left, all of them are given to a crew at once: the workers of the site's cluster, or
processes of this machine.  Each step keeps what was measured and what it says of it in one
transaction, so that a worker killed in between does no step twice and loses none.
"""

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path

import structlog

from station.documents import MeasurementDocument
from station.errors import InputUnusable
from station.pipeline import FRAME_S
from station.replay import (
    Crew,
    Failed,
    OtherSoftware,
    Workers,
    local_workers,
    sooner_by_workers,
    workers_at,
)
from station.store import (
    JOB,
    Job,
    JobState,
    JsonObject,
    Measurement,
    Recording,
    Replay,
    end,
    the,
)
from station.store.measured import add_measurements, note_measured
from station.worker.context import WorkContext
from station.worker.replay_orders import StepOrder, carry_out, order_of, rows_of
from station.worker.reporting import JobCancelled, JobProgress, begin, one_line

_STEPS_A_WORKER = 2
"""With fewer, some workers of this machine would have nothing to do while others measure long:
then all cores measure one recording after the other."""
_log = structlog.get_logger()


def begin_replay(context: WorkContext, job_id: str) -> int:
    """Take the job up and return how many steps it has; none where it has ended."""
    job = begin(context, job_id)
    if job is None:
        return 0
    with context.store.look() as session:
        return len(the(session, Replay, job.subject).steps["steps"])


def replay_step(context: WorkContext, job_id: str, place: int) -> None:
    """Measure what one step names and keep it, and where there is a crew, all steps behind it.

    A step that is kept already is not done again.
    """
    step = _Step(context, job_id, place)
    try:
        for hire in step.crews():
            try:
                with hire() as crew:
                    step.do_all_by(crew)
            except (InputUnusable, OtherSoftware) as error:
                step.say(f"{error}; going on with the cores of the station")
            else:
                return
        step.do()
    except JobCancelled:
        return


class _Step:
    """A step of a replay, with all that are left from there on."""

    def __init__(self, context: WorkContext, job_id: str, place: int) -> None:
        self._context, self._job_id, self._place = context, job_id, place
        with context.store.look() as session:
            self._row = the(session, Replay, the(session, Job, job_id).subject)
        self._steps: list[list[str]] = self._row.steps["steps"]

    def crews(self) -> Iterator[Callable[[], AbstractContextManager[Workers]]]:
        """Yield those who may do what is left, the best first; none where this is sooner done."""
        left = self._left()
        if self._steps[self._place] not in left:
            return
        cluster = self._context.settings.replay.cluster
        if cluster is not None and not self._said():
            if Path(self._row.reference).is_file():
                self.say(f"{self._row.reference} is a file of the station; measured here alone")
            else:
                yield partial(workers_at, cluster)
        left, count = self._left(), len(os.sched_getaffinity(0))
        alone_s = self._frames(left) * FRAME_S
        if len(left) >= _STEPS_A_WORKER * count and sooner_by_workers(alone_s, count):
            yield partial(local_workers, count)

    def do_all_by(self, crew: Crew) -> None:
        """Have a crew measure what is left, and keep each answer as it comes.

        Raises
        ------
        InputUnusable, OtherSoftware
            If the crew can do no more; what was kept stays.
        JobCancelled
            If somebody cancelled the job.
        """
        progress = JobProgress(self._context, self._job_id)
        left, of = self._left(), len(self._steps)
        done = of - len(left)

        def tell() -> None:
            progress(done / of, f"{done} of {of} recordings")

        for answer in crew.each(carry_out, self._orders(left), meanwhile=tell):
            if isinstance(answer, Failed):
                self._keep(answer.task.names, [], refused=answer.why)
            elif isinstance(answer.result, str):
                self._keep(answer.task.names, [], refused=answer.result)
            else:
                self._keep_found(answer.task.names, answer.result)
            done += 1
            tell()

    def do(self) -> None:
        """Measure what this step names, on the cores of this machine."""
        names = self._steps[self._place]
        if names not in self._left():
            return
        of = len(self._steps)
        progress = JobProgress(
            self._context, self._job_id, first=self._place / of, last=(self._place + 1) / of
        )
        try:
            found = order_of(self._context, self._row, names).measure(progress=progress)
        except JobCancelled:
            raise
        except Exception as error:  # noqa: BLE001  whatever happened, the job must end and say so
            self._keep(names, [], refused=one_line(error, self._job_id))
            return
        self._keep_found(names, found)

    def say(self, what: str) -> None:
        """Have the job tell one line, beside what it comes to."""
        _log.warning("replay not done by the cluster", job=self._job_id, why=what)
        with self._context.store.change() as session:
            job = the(session, Job, self._job_id)
            if job.state is JobState.RUNNING:
                job.error = what

    def _said(self) -> bool:
        with self._context.store.look() as session:
            return the(session, Job, self._job_id).error is not None

    def _left(self) -> list[list[str]]:
        with self._context.store.look() as session:
            if the(session, Job, self._job_id).state is not JobState.RUNNING:
                return []
            kept = the(session, Replay, self._row.id).results
        return [names for names in self._steps[self._place :] if names[0] not in kept]

    def _frames(self, steps: Sequence[Sequence[str]]) -> int:
        with self._context.store.look() as session:
            recordings = [the(session, Recording, name) for names in steps for name in names]
            return sum(each.recorded or 0 for each in recordings)

    def _orders(self, steps: Sequence[Sequence[str]]) -> Iterator[StepOrder]:
        for names in steps:
            try:
                order = order_of(self._context, self._row, names)
            except Exception as error:  # noqa: BLE001  as above: the others are done
                self._keep(names, [], refused=one_line(error, self._job_id))
            else:
                yield order

    def _keep_found(self, names: Sequence[str], found: MeasurementDocument) -> None:
        self._keep(names, rows_of(self._context, self._row, names, found))

    def _keep(
        self, names: Sequence[str], measured: Sequence[Measurement], *, refused: str | None = None
    ) -> None:
        with self._context.store.change() as session:
            if the(session, Job, self._job_id).state is not JobState.RUNNING:
                return
            replay = the(session, Replay, self._row.id)
            if names[0] in replay.results:
                return  # done before the worker was killed, which did not live to say so
            said: JsonObject = {"refused": refused}
            if refused is None:
                added = add_measurements(session, measured)
                note_measured(session, replay.id, measured)
                said = {"wheels": len(measured), "added": added}
            replay.results = {**replay.results, names[0]: said}


def conclude_replay(context: WorkContext, job_id: str) -> None:
    """End the job: failed where nothing could be measured; passes stay as they are."""
    with context.store.change() as session:
        job = the(session, Job, job_id)
        if job.state is not JobState.RUNNING:
            return
        results = the(session, Replay, job.subject).results
        refused = [
            f"{name}: {said['refused']}" for name, said in results.items() if "refused" in said
        ]
        failed = len(refused) == len(results)
        state = JobState.FAILED if failed else JobState.DONE
        told = [job.error] if job.error else []
        why = "; ".join([*told, *refused]) or ("there was nothing to measure" if failed else None)
        end(job, state, at=context.now(), error=why)


def fail_replay(context: WorkContext, job_id: str, why: str) -> None:
    """End the job; what it measured stays."""
    with context.store.change() as session:
        job = the(session, Job, job_id)
        if not JOB.ended(job.state):
            end(job, JobState.FAILED, at=context.now(), error=why)
