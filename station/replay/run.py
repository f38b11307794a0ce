"""Measuring recordings again: the same steps as a pass's, on as many cores as there are."""

import os
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from measure import Limits, Side
from station.documents import CalibrationDocument, RigDocument
from station.errors import StationError
from station.pipeline import FRAME_S, all_cores
from station.progress import Progress, silent
from station.replay.cluster import local_workers, workers_at
from station.replay.crew import Crew, Done, Failed, Here
from station.replay.means import Means
from station.replay.parts import Part, PartFolder
from station.replay.planning import planned
from station.replay.report import Refusal, ReplayForecast, ReplayReport
from station.replay.target import Target
from station.replay.task import ReplayTask
from station.replay.work import Answer, Doing, Order, do_order

_CLUSTER_START_S = 5.0
"""What it takes workers of this machine to start, about."""

Answers = Iterator[Done[ReplayTask, Answer] | Failed[ReplayTask]]


def replay_recordings(
    sources: Sequence[str | Path],
    calibration: CalibrationDocument | Sequence[CalibrationDocument],
    out: Path,
    *,
    rigs: Sequence[RigDocument] = (),
    reference: str = "S1002",
    limits: Limits | None = None,
    sides: Mapping[str, Side] | None = None,
    max_skew_us: Mapping[str, float] | None = None,
    cluster: str | None = None,
    workers: int | None = None,
    progress: Progress = silent,
) -> ReplayReport:
    """Measure the wheels in recordings and write them to a table, or to a folder of tables.

    Parameters
    ----------
    sources, out
        As of a `Replay`.
    calibration
        With those of several sensors, the wheels of each pass stand axle for axle. Those of a rig's
        sensors are taken in place of what the rig rests on.
    rigs
        Sensors that are measured together.
    reference, limits
        As of a measurement.
    sides
        The side of the train that each of several sensors looks at.
    max_skew_us
        Greatest time between frames of one shot, of single rigs.
    cluster, workers, progress
        As of `Replay.run`.

    Raises
    ------
    InputUnusable
        If a source is no recording by its name or given twice, two calibrations are of one sensor,
        two rigs share one, the table cannot be written, or the cluster cannot be used.
    """
    given = [calibration] if isinstance(calibration, CalibrationDocument) else calibration
    means = Means.of(
        given,
        rigs=rigs,
        reference=reference,
        limits=limits,
        sides=sides,
        max_skew_us=max_skew_us,
    )
    return Replay(sources, means, out).run(cluster=cluster, workers=workers, progress=progress)


class Replay:
    """Recordings to be measured, and where their wheels go.

    Of a recording that is damaged, or of a sensor without calibration, nothing is in the table,
    and the others are measured all the same. What is measured is kept at once: after a kill the
    same replay goes on. What is in memory does not grow with the recordings.
    """

    def __init__(self, sources: Sequence[str | Path], means: Means, out: Path) -> None:
        """Find the recordings.

        Parameters
        ----------
        sources
            Recordings of the means' sensors: files, folders, and URLs of both.
        means
            What to measure with.
        out
            The table (.json, .csv, .parquet); or a folder, which takes a Parquet table of each
            recording, or pass. What is measured on the way to a table is in a folder beside it.

        Raises
        ------
        InputUnusable
            If a source, the reference or a rig cannot be used.
        """
        self._target, self._means = Target.of(out), means
        self._lookers = means.lookers()
        self._heading = means.heading(self._lookers)
        self._unplanned: dict[str, str] = {}
        self._tasks = planned(sources, means, self._unplanned, by_address=self._target.is_folder)

    def forecast(self) -> ReplayForecast:
        """Return what a run would do; nothing is written."""
        parts = self._parts(make=False)
        todo = [task for task in self._tasks if parts.of(task) is None]
        return ReplayForecast(
            out=self._target.out,
            recordings=sum(len(task.recordings) for task in self._tasks),
            tasks=len(self._tasks),
            found_measured=len(self._tasks) - len(todo),
            frames=sum(task.frames for task in todo),
            refused=_refusals(self._unplanned),
        )

    def run(
        self,
        *,
        cluster: str | None = None,
        workers: int | None = None,
        progress: Progress = silent,
    ) -> ReplayReport:
        """Measure what is not measured yet, and make the table.

        Parameters
        ----------
        cluster
            Address of a Dask scheduler; its workers read the recordings at the same paths or URLs.
        workers
            Processes of this machine; as many as it has cores where not given, none where this
            process is sooner done.
        progress
            Told how far it is.

        Raises
        ------
        InputUnusable
            If the table cannot be written, or the cluster cannot be used.
        """
        parts = self._parts(make=True)
        todo = [task for task in self._tasks if parts.of(task) is None]
        keeping = _Keeping(parts, _Tally(todo, progress))
        if todo:
            with self._answers(todo, cluster, workers, keeping.tally.reading) as answers:
                keeping.keep(answers)
        return self._report(keeping, parts, found=len(self._tasks) - len(todo))

    def _parts(self, *, make: bool) -> PartFolder:
        target = self._target
        return PartFolder(target.parts, target.form, self._means.fingerprint, make=make)

    @contextmanager
    def _answers(
        self,
        todo: Sequence[ReplayTask],
        cluster: str | None,
        workers: int | None,
        reading: Callable[[int], None],
    ) -> Generator[Answers]:
        alone_s = sum(task.frames for task in todo) * FRAME_S
        count = workers or len(os.sched_getaffinity(0))
        if cluster is not None:
            with workers_at(cluster) as crew:
                yield self._ordered(crew, todo)
        elif workers is not None or _sooner_elsewhere(alone_s, min(count, len(todo))):
            with local_workers(min(count, len(todo))) as crew:
                yield self._ordered(crew, todo)
        else:
            skews = dict(self._means.max_skew_us)
            with all_cores(alone_s=alone_s) as cores:
                doing = Doing(
                    self._lookers, self._heading, self._target.form, skews, cores, reading
                )
                yield Here().each(doing.do, todo)

    def _ordered(self, crew: Crew, todo: Sequence[ReplayTask]) -> Answers:
        packed = self._means.packed()
        orders = (Order(task, packed, self._target.form) for task in todo)
        for answer in crew.each(do_order, orders):
            if isinstance(answer, Failed):
                yield Failed(answer.task.task, answer.why)
            else:
                yield Done(answer.task.task, answer.result)

    def _report(self, keeping: "_Keeping", parts: PartFolder, *, found: int) -> ReplayReport:
        place = {
            one.name: at
            for at, one in enumerate(one for task in self._tasks for one in task.recordings)
        }
        late = sorted(keeping.refused.items(), key=lambda one: place[one[0]])
        refused = self._unplanned | dict(late)
        used = [part for task in self._tasks if (part := keeping.part_of(task)) is not None]
        wheels, measured = self._target.join(self._heading, used)
        if not (self._target.is_folder or refused):
            parts.remove()
        return ReplayReport(
            out=self._target.out,
            recordings=len(place.keys() - refused.keys()),
            found_measured=found,
            frames=keeping.tally.frames,
            wheels=wheels,
            measured=measured,
            refused=_refusals(refused),
        )


class _Tally:
    """Counts the frames that are read, and tells how far it is."""

    def __init__(self, todo: Sequence[ReplayTask], progress: Progress) -> None:
        self.frames = 0
        self._total, self._done = max(1, sum(task.frames for task in todo)), 0
        self._tasks, self._tasks_done = len(todo), 0
        self._progress = progress

    def reading(self, frames: int) -> None:
        """Be told how many frames of a task have been read."""
        done = min(1.0, (self._done + frames) / self._total)
        self._progress(done, f"recording {self._tasks_done + 1} of {self._tasks}")

    def finished(self, task: ReplayTask, frames: int) -> None:
        """Be told that a task has ended."""
        self.frames += frames
        self._done += task.frames
        self._tasks_done += 1
        done = min(1.0, self._done / self._total)
        self._progress(done, f"{self._tasks_done} of {self._tasks} recordings")


class _Keeping:
    """Keeps what came of each task."""

    def __init__(self, parts: PartFolder, tally: _Tally) -> None:
        self.tally = tally
        self.refused: dict[str, str] = {}
        self._parts = parts
        self._fresh: dict[ReplayTask, Part] = {}

    def keep(self, answers: Answers) -> None:
        """Keep the answers as they come."""
        for one in answers:
            if isinstance(one, Failed):
                self._refuse(one.task, one.why)
                self.tally.finished(one.task, 0)
                continue
            task, answer = one.task, one.result
            self.refused |= {refusal.recording: refusal.reason for refusal in answer.refused}
            if answer.held:
                try:
                    self._fresh[task] = self._parts.put(task.name, answer.held, answer.content)
                except StationError as error:
                    self._refuse(task, str(error))
            self.tally.finished(task, answer.frames)

    def part_of(self, task: ReplayTask) -> Part | None:
        """Return the part with the wheels of a task, where there is one."""
        return self._fresh.get(task) or self._parts.of(task)

    def _refuse(self, task: ReplayTask, why: str) -> None:
        self.refused |= dict.fromkeys((one.name for one in task.recordings), why)


def _sooner_elsewhere(alone_s: float, count: int) -> bool:
    return count > 1 and alone_s > alone_s / count + _CLUSTER_START_S


def _refusals(refused: Mapping[str, str]) -> tuple[Refusal, ...]:
    return tuple(Refusal(name, reason) for name, reason in refused.items())
