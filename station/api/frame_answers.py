"""What comes out over HTTP of the frames of a recording."""

from datetime import UTC, datetime
from typing import Self

from station.api.answers import Out
from station.recording import ListedFrame

_NS_PER_S = 1_000_000_000


class FrameModel(Out):
    """One frame of a recording."""

    number: int
    """Its place in the recording, from 1."""
    frame: int
    """As the camera numbers them; measurements name it."""
    sensor: str
    time: datetime
    """When it was exposed."""
    received: datetime
    """When it came, by the station's clock."""

    @classmethod
    def of(cls, found: ListedFrame) -> Self:
        return cls(
            number=found.number,
            frame=found.frame_id,
            sensor=found.sensor,
            time=_moment(found.camera_time_ns),
            received=_moment(found.host_time_ns),
        )


def _moment(time_ns: int) -> datetime:
    """Return a time to the microsecond.

    >>> _moment(1_782_907_200_123_456_789).isoformat()
    '2026-07-01T12:00:00.123456+00:00'
    """
    seconds, rest_ns = divmod(time_ns, _NS_PER_S)
    return datetime.fromtimestamp(seconds, UTC).replace(microsecond=rest_ns // 1000)


class FramesPage(Out):
    """Some frames; `next` is the `after` of the next page, null on the last."""

    frames: list[FrameModel]
    next: int | None
