"""Mapping work over all cores, in order, with few pictures in flight."""

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from multiprocessing import get_context
from typing import TypeVar

import cv2

_START_S = 2.0
"""What it takes a process to start and import the mathematics."""

Task = TypeVar("Task")
Answer = TypeVar("Answer")


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
    cores = len(os.sched_getaffinity(0))
    alone_s = count * seconds_each
    if alone_s < alone_s / cores + _START_S:
        yield from map(work, tasks)
        return
    # Spawned, not forked: the callers hold threads.
    with ProcessPoolExecutor(
        cores, mp_context=get_context("spawn"), initializer=cv2.setNumThreads, initargs=(1,)
    ) as pool:
        flying: deque[Future[Answer]] = deque()
        for task in tasks:
            flying.append(pool.submit(work, task))
            if len(flying) > 2 * cores:
                yield flying.popleft().result()
        while flying:
            yield flying.popleft().result()
