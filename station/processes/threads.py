"""Doing the same for several things at a time, each in a thread of its own."""

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from typing import TypeVar

Thing = TypeVar("Thing")
Answer = TypeVar("Answer")


def at_a_time(do: Callable[[Thing], Answer], things: Iterable[Thing]) -> list[Answer]:
    """Return what `do` makes of each thing, in their order; the first error is raised.

    Lines that the threads log name the request, the pass and what else the caller's lines name.
    """
    # A context can be entered by one thread at a time: each gets a copy.
    todo = [(copy_context(), thing) for thing in things]
    if not todo:
        return []
    with ThreadPoolExecutor(max_workers=len(todo)) as pool:
        return list(pool.map(lambda one: one[0].run(do, one[1]), todo))
