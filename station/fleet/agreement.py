"""Whether stations read the same wheel alike: its wear, and what each station adds to it.

Pure: values in, offsets with their uncertainty out.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from measure import Rate
from station.fleet.wear import StationValue, mean_u95, wear_of


@dataclass(frozen=True, slots=True)
class StationOffset:
    """What a station reads more than the one that the others are held against.

    Attributes
    ----------
    values
        It rests on so many of this station's.
    u95_mm
        Half-width of the 95 % interval of `offset_mm` if both stations' u95 are right.
    agrees
        Whether zero lies in the interval.
    """

    station: str
    values: int
    offset_mm: float
    u95_mm: float

    @property
    def agrees(self) -> bool:
        return abs(self.offset_mm) <= self.u95_mm


@dataclass(frozen=True, slots=True)
class Agreement:
    """A wheel's wear over all stations, and the offsets of the others against `held_against`."""

    held_against: str
    per_day: Rate
    offsets: tuple[StationOffset, ...]


def station_agreement(values: Sequence[StationValue]) -> Agreement | None:
    r"""Tell what each station reads more than the one with the most values.

    Parameters
    ----------
    values
        Of one quantity of one wheel, none from before it was turned or changed.

    Returns
    -------
    Agreement or None
        None of fewer than two stations.

    Notes
    -----
    Wear and offsets are those of `wear_of`.  A station's error is mostly that of its calibration,
    the same in all its values: it does not go down with their number.  The interval is therefore
    that of the offset of two values, one of each station, and of the wear between the stations'
    mean times, :math:`u_b` that of the rate:

    .. math:: u^2 = \overline{u_{95,s}^2} + \overline{u_{95,0}^2} + (u_b\,(\bar t_s - \bar t_0))^2

    It is too large where the errors are independent, never too small.
    """
    counted = Counter(each.station for each in values)
    if len(counted) < 2 or (wear := wear_of(values)) is None:
        return None
    first = wear.held_against
    offsets = tuple(
        StationOffset(name, counted[name], offset, _interval(values, name, first, wear.per_day))
        for name, offset in wear.offsets_mm.items()
    )
    return Agreement(first, wear.per_day, offsets)


def _interval(values: Sequence[StationValue], one: str, other: str, per_day: Rate) -> float:
    apart = _mean_day(values, one) - _mean_day(values, other)
    own = mean_u95(values, one) ** 2 + mean_u95(values, other) ** 2
    return float((own + (per_day.u95_mm * apart) ** 2) ** 0.5)


def _mean_day(values: Sequence[StationValue], station: str) -> float:
    days = [each.day for each in values if each.station == station]
    return sum(days) / len(days)
