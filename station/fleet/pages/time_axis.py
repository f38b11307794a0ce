"""Round moments along an axis of time, written as ISO does; UTC."""

from datetime import UTC, datetime, timedelta
from math import ceil

_MOST = 6
_DAY_STEPS = (1, 2, 5, 10, 20)
_MONTH_STEPS = (1, 2, 3, 6, 12, 24, 60, 120)
_DAYS_A_MONTH = 30.44


def moments_along(first: datetime, last: datetime) -> list[tuple[datetime, str]]:
    """Return round moments from `first` to `last`, six at most, each with its label.

    Examples
    --------
    >>> june = datetime(2026, 6, 20, 8, tzinfo=UTC)
    >>> [text for _, text in moments_along(june, june + timedelta(days=9))]
    ['2026-06-21', '2026-06-23', '2026-06-25', '2026-06-27', '2026-06-29']
    >>> [text for _, text in moments_along(june, june + timedelta(days=300))]
    ['2026-07', '2026-09', '2026-11', '2027-01', '2027-03']
    """
    days = (last - first) / timedelta(days=1)
    for step in _DAY_STEPS:
        if days / step <= _MOST:
            return _days(first, last, step)
    months = days / _DAYS_A_MONTH
    step = next((each for each in _MONTH_STEPS if months / each <= _MOST), ceil(months / _MOST))
    return _months(first, last, step)


def _days(first: datetime, last: datetime, step: int) -> list[tuple[datetime, str]]:
    at = first.astimezone(UTC).replace(hour=0, minute=0, second=0, microsecond=0)
    found = []
    while at <= last:
        if at >= first:
            found.append((at, f"{at:%Y-%m-%d}"))
        at += timedelta(days=step if found else 1)
    return found


def _months(first: datetime, last: datetime, step: int) -> list[tuple[datetime, str]]:
    begun = first.astimezone(UTC)
    count = begun.year * 12 + begun.month - 1
    found = []
    for each in range(ceil(count / step) * step, count + 12_000, step):
        at = datetime(each // 12, each % 12 + 1, 1, tzinfo=UTC)
        if at > last:
            break
        if at >= first:
            found.append((at, f"{at:%Y-%m}"))
    return found
