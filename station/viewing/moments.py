"""Times of frames as documents and headers have them."""

from datetime import UTC, datetime

_NS_PER_S, _NS_PER_US = 1_000_000_000, 1_000


def moment(time_ns: int) -> str:
    """Return a time, UTC, to the microsecond.

    >>> moment(1_782_907_200_123_456_789)
    '2026-07-01T12:00:00.123456Z'
    """
    seconds, rest_ns = divmod(time_ns, _NS_PER_S)
    told = datetime.fromtimestamp(seconds, UTC).replace(microsecond=rest_ns // _NS_PER_US)
    return told.isoformat(timespec="microseconds").replace("+00:00", "Z")
