"""Numbers and times as the pages show them: always with their unit, times in the station's zone."""

from datetime import UTC, datetime, timedelta, tzinfo
from typing import Final

from markupsafe import Markup

NARROW_SPACE: Final = "\u202f"
_MINUS: Final = "\u2212"
_NONE: Final = "\u2013"
_STEPS: Final = (("d", 86_400), ("h", 3600), ("min", 60), ("s", 1))
_TIME: Final = Markup(
    '<time datetime="{iso}"><span class="local">{local}</span><span class="utc">{utc}</span></time>'
)


def quantity(value: float | None, unit: str, digits: int = 2) -> str:
    """Return a value with its unit; a dash where there is none.

    >>> quantity(-0.123, "mm"), quantity(None, "mm")
    ('\u22120.12\u202fmm', '\u2013')
    """
    if value is None:
        return _NONE
    text = f"{value:.{digits}f}"
    if float(text) == 0.0:
        text = text.removeprefix("-")
    return f"{text.replace('-', _MINUS)}{NARROW_SPACE}{unit}"


def bytes_of(count: int | None) -> str:
    """Return a size in the decimal units that disks are sold by.

    >>> bytes_of(1_234_000_000), bytes_of(512)
    ('1.23\u202fGB', '512\u202fB')
    """
    if count is None:
        return _NONE
    for unit, size in (("TB", 10**12), ("GB", 10**9), ("MB", 10**6), ("kB", 10**3)):
        if count >= size:
            return f"{count / size:.3g}{NARROW_SPACE}{unit}"
    return f"{count}{NARROW_SPACE}B"


def lasting(seconds: float | None) -> str:
    """Return a duration in its largest one or two units.

    >>> lasting(4000), lasting(0.5), lasting(86400)
    ('1\u202fh 6\u202fmin', '0\u202fs', '1\u202fd')
    """
    if seconds is None:
        return _NONE
    left, words = int(seconds), []
    for unit, length in _STEPS:
        count, left = divmod(left, length)
        if count:
            words.append(f"{count}{NARROW_SPACE}{unit}")
    return " ".join(words[:2]) or f"0{NARROW_SPACE}s"


class Times:
    """Moments in the station's zone, and in UTC at the touch of a button."""

    def __init__(self, zone: tzinfo | None) -> None:
        self._zone = zone

    def when(self, moment: datetime | None) -> Markup | str:
        """Return a moment as an element that holds it in both zones; a dash where there is none."""
        if moment is None:
            return _NONE
        return self._element(moment, "%Y-%m-%d %H:%M:%S")

    def clock(self, moment: datetime | None) -> Markup | str:
        """Return the time of day of a moment, as `when` does."""
        return _NONE if moment is None else self._element(moment, "%H:%M:%S")

    def ago(self, moment: datetime | None, now: datetime) -> str:
        """Return how long ago a moment was."""
        return _NONE if moment is None else lasting(max((now - moment) / timedelta(seconds=1), 0))

    def _element(self, moment: datetime, form: str) -> Markup:
        utc, local = moment.astimezone(UTC), moment.astimezone(self._zone)
        return _TIME.format(
            iso=utc.strftime("%Y-%m-%dT%H:%M:%SZ"),
            local=f"{local.strftime(form)} {local.tzname()}",
            utc=f"{utc.strftime(form)} UTC",
        )
