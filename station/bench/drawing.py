"""Many draws of a simulation, done by whoever there is; the answers come in the order of the draws.

Each draw has a seed of its own: the figures are the same whoever does them, and however many.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from station.errors import StationError
from station.pipeline import map_on_all_cores
from station.replay import Crew, Failed

Draw = TypeVar("Draw")
Drawn = TypeVar("Drawn")

_TASK_S = 1.0
"""A task is worth sending from about there on."""


@dataclass(frozen=True, slots=True)
class Drawing:
    """Who does the draws: all cores of this machine, or a crew."""

    crew: Crew | None = None

    def map(
        self, work: Callable[[Draw], Drawn], draws: Sequence[Draw], *, seconds_each: float
    ) -> Iterator[Drawn]:
        """Yield ``work(draw)`` in order.

        Parameters
        ----------
        work
            Importable by name.
        draws
            Each with what it begins from.
        seconds_each
            What one takes, about.

        Raises
        ------
        StationError
            If a crew could not do one.
        """
        if self.crew is None:
            yield from map_on_all_cores(work, draws, count=len(draws), seconds_each=seconds_each)
            return
        each = max(1, round(_TASK_S / seconds_each))
        places = range(0, len(draws), each)
        tasks = (_Some(work, at, tuple(draws[at : at + each])) for at in places)
        waiting: dict[int, list[Drawn]] = {}
        due = 0
        for answer in self.crew.each(_do_some, tasks):
            if isinstance(answer, Failed):
                at = answer.task.place
                raise StationError(f"draw {at} and those behind it not done: {answer.why}")
            waiting[answer.task.place] = answer.result
            while due in waiting:
                yield from waiting.pop(due)
                due += each


ON_ALL_CORES = Drawing()


@dataclass(frozen=True, slots=True, eq=False)
class _Some:
    """Draws that are done in one go."""

    work: Callable[[Any], Any]
    place: int
    draws: tuple[Any, ...]


def _do_some(some: _Some) -> list[Any]:
    return [some.work(draw) for draw in some.draws]
