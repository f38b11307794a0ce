"""Mapping work over all cores, in order, with few pictures in flight."""

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from multiprocessing import get_context
from typing import TypeVar

import cv2

_FEWEST_FOR_PROCESSES = 6
"""Starting a process costs as much as looking at about six pictures."""

Task = TypeVar("Task")
Answer = TypeVar("Answer")


def map_on_all_cores(work: Callable[[Task], Answer], tasks: Iterable[Task]) -> Iterator[Answer]:
    """Yield ``work(task)`` in order; a handful of tasks stays in this process.

    `work` must be importable by name, as it runs in processes of its own.
    """
    cores = len(os.sched_getaffinity(0))
    waiting_tasks = iter(tasks)
    head = [task for _, task in zip(range(_FEWEST_FOR_PROCESSES), waiting_tasks, strict=False)]
    if len(head) < _FEWEST_FOR_PROCESSES or cores == 1:
        yield from map(work, head)
        yield from map(work, waiting_tasks)
        return
    # Spawned, not forked: the callers hold threads.
    with ProcessPoolExecutor(
        cores, mp_context=get_context("spawn"), initializer=cv2.setNumThreads, initargs=(1,)
    ) as pool:
        flying: deque[Future[Answer]] = deque(pool.submit(work, task) for task in head)
        for task in waiting_tasks:
            yield flying.popleft().result()
            flying.append(pool.submit(work, task))
        while flying:
            yield flying.popleft().result()
