"""Measuring recordings again: the same steps as a pass's, on as many cores as there are."""

import os
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

from measure import Limits, Side
from station.documents import CalibrationDocument, RigDocument
from station.pipeline import FRAME_S, all_cores
from station.progress import Progress, silent
from station.replay.cluster import local_workers, sooner_by_workers, workers_at
from station.replay.crew import Crew, Done, Failed, Here
from station.replay.keeping import Answers, Keeping, Tally
from station.replay.means import Means
from station.replay.parts import PartFolder
from station.replay.planning import planned
from station.replay.report import Refusal, ReplayForecast, ReplayReport
from station.replay.target import Target
from station.replay.task import ReplayTask
from station.replay.work import Doing, Order, do_order


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
        todo = self._todo(parts)
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
        todo = self._todo(parts)
        tally = Tally(todo, progress)
        with self._answers(todo, cluster, workers, tally) as answers:
            return self._kept(parts, answers, tally, found=len(self._tasks) - len(todo))

    def run_with(self, crew: Crew, progress: Progress = silent) -> ReplayReport:
        """Do the same with a crew that is there already, for more than one replay.

        Raises
        ------
        InputUnusable
            As of `run`.
        """
        parts = self._parts(make=True)
        todo = self._todo(parts)
        answers = self._ordered(crew, todo)
        return self._kept(parts, answers, Tally(todo, progress), found=len(self._tasks) - len(todo))

    def _todo(self, parts: PartFolder) -> list[ReplayTask]:
        return [task for task in self._tasks if parts.of(task) is None]

    def _parts(self, *, make: bool) -> PartFolder:
        target = self._target
        return PartFolder(target.parts, target.form, self._means.fingerprint, make=make)

    @contextmanager
    def _answers(
        self,
        todo: Sequence[ReplayTask],
        cluster: str | None,
        workers: int | None,
        tally: Tally,
    ) -> Generator[Answers]:
        alone_s = sum(task.frames for task in todo) * FRAME_S
        count = min(workers or len(os.sched_getaffinity(0)), len(todo))
        if not todo:
            yield iter(())
        elif cluster is not None:
            with workers_at(cluster) as crew:
                yield self._ordered(crew, todo)
        elif workers is not None or sooner_by_workers(alone_s, count):
            with local_workers(count) as crew:
                yield self._ordered(crew, todo)
        else:
            skews = dict(self._means.max_skew_us)
            with all_cores(alone_s=alone_s) as cores:
                doing = Doing(
                    self._lookers, self._heading, self._target.form, skews, cores, tally.reading
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

    def _kept(
        self, parts: PartFolder, answers: Answers, tally: Tally, *, found: int
    ) -> ReplayReport:
        """Keep the answers as they come, and make the table."""
        keeping = Keeping(parts, tally)
        keeping.keep(answers)
        recordings = [one.name for task in self._tasks for one in task.recordings]
        refused = self._unplanned | {
            name: keeping.refused[name] for name in recordings if name in keeping.refused
        }
        used = [part for task in self._tasks if (part := keeping.part_of(task)) is not None]
        wheels, measured = self._target.join(self._heading, used)
        if not (self._target.is_folder or refused):
            parts.remove()
        return ReplayReport(
            out=self._target.out,
            recordings=len(recordings) - len(keeping.refused),
            found_measured=found,
            frames=tally.frames,
            wheels=wheels,
            measured=measured,
            refused=_refusals(refused),
        )


def _refusals(refused: Mapping[str, str]) -> tuple[Refusal, ...]:
    return tuple(Refusal(name, reason) for name, reason in refused.items())
