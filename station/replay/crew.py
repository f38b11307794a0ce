"""Those who do tasks: this process, or workers of a Dask cluster; the answers come in any order."""

import time
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import CancelledError
from dataclasses import dataclass
from itertools import islice
from typing import Any, Generic, Protocol, TypeVar

from station.errors import InputUnusable, StationError

Task = TypeVar("Task")
Result = TypeVar("Result")

_AHEAD = 2
"""Tasks that each thread of a worker has, so that it need not wait for the next."""
_COUNT_EACH_S = 5.0
_NO_WORKER_S = 60.0


@dataclass(frozen=True, slots=True)
class Done(Generic[Task, Result]):
    """A task and what came of it."""

    task: Task
    result: Result


@dataclass(frozen=True, slots=True)
class Failed(Generic[Task]):
    """A task that could not be done, and why."""

    task: Task
    why: str


class Crew(Protocol):
    """Does tasks."""

    def each(
        self,
        work: Callable[[Task], Result],
        tasks: Iterable[Task],
        *,
        meanwhile: Callable[[], None] = lambda: None,
    ) -> Iterator[Done[Task, Result] | Failed[Task]]:
        """Yield what came of each task, as it is done; a `StationError` of `work` ends it all.

        Parameters
        ----------
        work
            Importable by name.
        tasks
            Taken one by one, only a few ahead of the answers.
        meanwhile
            Called every few seconds while others work; what it raises ends it all.
        """


class Here:
    """Does tasks one after the other in this process."""

    def each(
        self,
        work: Callable[[Task], Result],
        tasks: Iterable[Task],
        *,
        meanwhile: Callable[[], None] = lambda: None,
    ) -> Iterator[Done[Task, Result] | Failed[Task]]:
        for task in tasks:
            meanwhile()
            try:
                yield Done(task, work(task))
            except StationError:
                raise
            except Exception as error:  # whatever is wrong with one task, the others are done
                yield Failed(task, _named(error))


class Workers:
    """Has tasks done by the workers of a Dask client.

    A few tasks for each worker are on their way, however many there are: a scheduler with 10,000
    is no slower than one with ten, and what is left when this process ends is little.

    A task whose worker dies is done by another.  What is on its way together with a task that
    kills workers is suspected as well: suspects are done again, each by itself, and the one that
    kills once more is named.
    """

    def __init__(self, client: Any, refill: Callable[[], None] = lambda: None) -> None:
        """Take a client, and what starts workers where some are gone for good."""
        self._client, self._refill = client, refill
        self._threads, self._counted = 0, float("-inf")

    def each(
        self,
        work: Callable[[Task], Result],
        tasks: Iterable[Task],
        *,
        meanwhile: Callable[[], None] = lambda: None,
    ) -> Iterator[Done[Task, Result] | Failed[Task]]:
        suspects: list[Task] = []
        for answer in self._tried(work, iter(tasks), self._ahead, meanwhile):
            if isinstance(answer, _Killer):
                suspects.append(answer.task)
            else:
                yield answer
        for answer in self._tried(work, iter(suspects), lambda: 1, meanwhile):
            if isinstance(answer, _Killer):
                yield Failed(answer.task, answer.why)
            else:
                yield answer

    def on_each(self, work: Callable[[], Result]) -> list[Result]:
        """Return what a function, importable by name, gives on each of the workers there are."""
        return list(self._client.run(work).values())

    def _tried(
        self,
        work: Callable[[Task], Result],
        tasks: Iterator[Task],
        ahead: Callable[[], int],
        meanwhile: Callable[[], None],
    ) -> Generator["Done[Task, Result] | Failed[Task] | _Killer[Task]"]:
        flying: dict[Any, Task] = {}
        try:
            while True:
                for task in islice(tasks, max(0, ahead() - len(flying))):
                    # Not pure: equal tasks of a second replay have nothing to do with these.
                    flying[self._client.submit(work, task, pure=False)] = task
                if not flying:
                    return
                for future in self._landed(flying, meanwhile):
                    task = flying.pop(future)
                    answer = _answer(future, task)
                    future.release()
                    yield answer
        finally:
            # Where the caller has gone: what is not done yet is wanted by nobody.
            if flying and self._client.status == "running":
                self._client.cancel(list(flying), force=True)

    def _landed(self, flying: Iterable[Any], meanwhile: Callable[[], None]) -> Iterable[Any]:
        """Return the tasks that are done, as soon as there is one.

        Raises
        ------
        InputUnusable
            If the scheduler is gone, or has had no worker for a while.
        """
        from distributed import wait  # noqa: PLC0415  costs 0.5 s: only where it is used

        gone_at = time.monotonic() + _NO_WORKER_S
        while True:
            try:
                with self._client.as_current():
                    done: Iterable[Any] = wait(
                        list(flying), timeout=_COUNT_EACH_S, return_when="FIRST_COMPLETED"
                    ).done
            except TimeoutError:
                meanwhile()
                if self._threads_now():
                    gone_at = time.monotonic() + _NO_WORKER_S
                elif time.monotonic() > gone_at:
                    raise InputUnusable(
                        f"the cluster has had no worker for {_NO_WORKER_S:.0f} s; start some and "
                        "replay again, what was measured stays"
                    ) from None
            except (CancelledError, OSError) as error:
                raise InputUnusable(
                    "the cluster's scheduler is gone; start it and replay again, what was measured "
                    "stays"
                ) from error
            else:
                return done

    def _threads_now(self) -> int:
        self._refill()
        try:
            return sum(self._client.nthreads().values())
        except OSError:
            return 0

    def _ahead(self) -> int:
        now = time.monotonic()
        if now - self._counted > _COUNT_EACH_S:
            self._threads, self._counted = self._threads_now(), now
        return _AHEAD * max(1, self._threads)


@dataclass(frozen=True, slots=True)
class _Killer(Generic[Task]):
    """A task whose workers died, perhaps of another that was on its way with it."""

    task: Task
    why: str


def _answer(future: Any, task: Task) -> "Done[Task, Any] | Failed[Task] | _Killer[Task]":
    from distributed import KilledWorker  # noqa: PLC0415  see above

    try:
        return Done(task, future.result())
    except StationError:
        raise
    except KilledWorker as error:
        deaths = error.allowed_failures + 1
        return _Killer(
            task, f"{deaths} workers died of it, out of memory or killed; measure it by itself"
        )
    except (CancelledError, OSError) as error:
        raise InputUnusable(
            "the cluster's scheduler is gone; start it and replay again, what was measured stays"
        ) from error
    except Exception as error:  # whatever it was at the worker, the others are done
        return Failed(task, _named(error))


def _named(error: Exception) -> str:
    return f"{type(error).__name__}: {' '.join(str(error).split())}"
