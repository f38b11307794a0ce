"""Keeping what comes of each task at once, and telling how far it is."""

from collections.abc import Iterator, Sequence

from station.errors import StateConflict
from station.progress import Progress
from station.replay.crew import Done, Failed
from station.replay.parts import Part, PartFolder
from station.replay.task import ReplayTask
from station.replay.work import Answer

Answers = Iterator[Done[ReplayTask, Answer] | Failed[ReplayTask]]


class Tally:
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


class Keeping:
    """Keeps what came of each task.

    Attributes
    ----------
    refused
        Recordings of which nothing is kept, and why.
    """

    def __init__(self, parts: PartFolder, tally: Tally) -> None:
        self.refused: dict[str, str] = {}
        self._parts, self._tally = parts, tally
        self._fresh: dict[ReplayTask, Part] = {}

    def keep(self, answers: Answers) -> None:
        """Keep the answers as they come.

        Raises
        ------
        InputUnusable
            If the disk takes no more; what was kept stays.
        """
        for one in answers:
            if isinstance(one, Failed):
                self._refuse(one.task, one.why)
                self._tally.finished(one.task, 0)
            else:
                self._keep(one.task, one.result)
                self._tally.finished(one.task, one.result.frames)

    def part_of(self, task: ReplayTask) -> Part | None:
        """Return the part with the wheels of a task, where there is one."""
        return self._fresh.get(task) or self._parts.of(task)

    def _keep(self, task: ReplayTask, answer: Answer) -> None:
        self.refused |= {refusal.recording: refusal.reason for refusal in answer.refused}
        if not answer.held:
            return
        try:
            self._fresh[task] = self._parts.put(task.name, answer.held, answer.content)
        except StateConflict as error:
            self._refuse(task, str(error))

    def _refuse(self, task: ReplayTask, why: str) -> None:
        self.refused |= dict.fromkeys((one.name for one in task.recordings), why)
