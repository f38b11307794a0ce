"""How the frames and events of a recording lie in time: of a size that does not grow with it.

All times are those of reception by the host's clock, which frames and events share.
"""

import heapq
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from station.recording import LOSSES, Event, EventKind, FrameTable, events
from station.viewing.moments import moment

_BINS = 240
_MOST_EVENTS = 200
_NS_PER_S = 1e9
_NO_NEWS = frozenset({EventKind.EXPOSED, EventKind.CONTINUED_FROM, EventKind.CONTINUED_IN})
"""One for each frame of a sequence, and what only tells that a file follows another."""


def timeline_json(table: FrameTable | None, frame_ids: Sequence[int]) -> dict[str, Any]:
    """Return the time line of a finished recording.

    Parameters
    ----------
    table
        Its frames; at least one.
    frame_ids
        Frames whose places are wanted, as the camera numbers them.

    Returns
    -------
    document
        `from`, `seconds`; `bins`: in equal parts of the time, the frames of each and the number of
        the first frame from there on; `events`, each with the `number` of the frame to look at: of
        too many those without a loss are left out first, and `events_left_out` says how many;
        `places`: number and time of `frame_ids`.

    Raises
    ------
    InputUnusable
        If a file has gone meanwhile.
    RecordingUnreadable
        If an event is damaged.
    ValueError
        If the recording grows: it has no end yet.
    """
    if table is None or len(table) == 0:
        raise ValueError("a time line is of a finished recording with frames")
    told = [each for each in _events(table) if each.kind not in _NO_NEWS]
    times_ns = np.maximum.accumulate(table.host_times_ns)  # a clock may have been set back
    start_ns = min([int(times_ns[0]), *(each.time_ns for each in told)])
    end_ns = max([int(times_ns[-1]), *(each.time_ns for each in told)])
    kept = _most_telling(told)
    return {
        "from": moment(start_ns),
        "seconds": (end_ns - start_ns) / _NS_PER_S,
        "frames": len(table),
        "bins": _bins((times_ns - start_ns) / _NS_PER_S, (end_ns - start_ns) / _NS_PER_S),
        "events": [_event(each, table, times_ns, start_ns) for each in kept],
        "events_left_out": len(told) - len(kept),
        "places": {
            str(frame_id): {"number": number, "at_s": _at_s(int(times_ns[number - 1]), start_ns)}
            for frame_id, number in table.numbers_of(frame_ids).items()
        },
    }


def _events(table: FrameTable) -> Iterable[Event]:
    return (each for file in table.files for each in events(file.path))


def _most_telling(told: Sequence[Event]) -> list[Event]:
    """Return the events in order of time; of too many, losses stay longest."""
    places = heapq.nsmallest(
        _MOST_EVENTS, range(len(told)), key=lambda place: (told[place].kind not in LOSSES, place)
    )
    return sorted((told[place] for place in places), key=lambda each: each.time_ns)


def _bins(at_s: NDArray[np.float64], seconds: float) -> dict[str, Any]:
    edges = np.linspace(0.0, seconds, _BINS + 1) if seconds > 0.0 else np.array([0.0, 1.0])
    firsts = np.searchsorted(at_s, edges[:-1])
    ends = np.append(firsts[1:], len(at_s))
    return {
        "frames": (ends - firsts).tolist(),
        "first": np.minimum(firsts + 1, len(at_s)).tolist(),
    }


def _event(
    event: Event, table: FrameTable, times_ns: NDArray[np.int64], start_ns: int
) -> dict[str, Any]:
    return {
        "at_s": _at_s(event.time_ns, start_ns),
        "time": moment(event.time_ns),
        "kind": event.kind,
        "detail": event.detail,
        "frame": event.frame_id,
        "count": event.count,
        "loss": event.kind in LOSSES,
        "number": _number(event, table, times_ns),
    }


def _number(event: Event, table: FrameTable, times_ns: NDArray[np.int64]) -> int:
    """Return the frame to look at: the first from the one concerned on, else the last one before.

    A loss that was found only at the end is looked for where it was, not when.
    """
    ids = table.frame_ids
    if event.frame_id is not None and np.all(ids[1:] > ids[:-1]):
        return min(int(np.searchsorted(ids, event.frame_id)) + 1, len(table))
    # Where the camera began to count anew, an id is of several frames.
    return max(int(np.searchsorted(times_ns, event.time_ns, side="right")), 1)


def _at_s(time_ns: int, start_ns: int) -> float:
    return round((time_ns - start_ns) / _NS_PER_S, 6)
