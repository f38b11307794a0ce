"""Mapping work over all cores, in order, with few pictures in flight."""

import os
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass
from typing import TypeVar

from station.processes.pool import pool_of_processes

_START_S = 2.0
"""What it takes a process to start and import the mathematics."""

Task = TypeVar("Task")
Answer = TypeVar("Answer")


@dataclass(frozen=True, slots=True)
class Cores:
    """Where work is done: in processes of their own, or here where that is sooner done."""

    pool: ProcessPoolExecutor | None
    ahead: int = 0
    """How many tasks are taken before the first answer is given."""

    def map(self, work: Callable[[Task], Answer], tasks: Iterable[Task]) -> Iterator[Answer]:
        """Yield ``work(task)`` in order; tasks are taken one by one, a few ahead of the answers.

        The tasks may themselves be the answers of another map on the same cores.
        """
        if self.pool is None:
            yield from map(work, tasks)
            return
        flying: deque[Future[Answer]] = deque()
        for task in tasks:
            flying.append(self.pool.submit(work, task))
            if len(flying) > self.ahead:
                yield flying.popleft().result()
        while flying:
            yield flying.popleft().result()


@contextmanager
def all_cores(*, alone_s: float) -> Generator[Cores]:
    """Give work to all cores while the block runs; `alone_s` is what one would take, about."""
    count = len(os.sched_getaffinity(0))
    if alone_s < alone_s / count + _START_S:
        yield Cores(None)
        return
    with pool_of_processes(count) as pool:
        yield Cores(pool, ahead=2 * count)


def these_or_all_cores(cores: Cores | None, *, alone_s: float) -> AbstractContextManager[Cores]:
    """Return the cores that were given, or else all."""
    return all_cores(alone_s=alone_s) if cores is None else nullcontext(cores)


def map_on_all_cores(
    work: Callable[[Task], Answer], tasks: Iterable[Task], *, count: int, seconds_each: float
) -> Iterator[Answer]:
    """Yield ``work(task)`` in order, in processes of their own where that is sooner done.

    Parameters
    ----------
    work
        Importable by name.
    tasks
        Taken one by one, only a few ahead of the answers.
    count
        How many there are, about.
    seconds_each
        What one takes, about.
    """
    with all_cores(alone_s=count * seconds_each) as cores:
        yield from cores.map(work, tasks)
