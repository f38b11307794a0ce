"""When a wheel will be at its limit, and how surely.

Pure: a line of wear and a limit in, days out.
"""

from dataclasses import dataclass
from math import inf, sqrt

from station.fleet.wear import Wear


@dataclass(frozen=True, slots=True)
class Forecast:
    """When a quantity meets the limit that wear leads to.

    Attributes
    ----------
    limit_mm
        The limit.
    margin_mm
        What is left to it at the last value; negative where it is beyond.
    per_day_mm
        How fast the margin goes.
    expected_day
        When the line meets the limit; infinite where it does not lead there.
    earliest_day, latest_day
        Ends of the 95 % interval; infinite where the rate is not known well enough to name one.
    """

    limit_mm: float
    margin_mm: float
    per_day_mm: float
    expected_day: float
    earliest_day: float
    latest_day: float

    @property
    def sure(self) -> bool:
        """Whether the wheel certainly goes to the limit: both ends of the interval are known."""
        return self.latest_day < inf


def forecast_of(wear: Wear, limit_mm: float, *, grows: bool) -> Forecast:
    r"""Foretell when a line of wear meets a limit.

    Parameters
    ----------
    grows
        Whether wear makes the quantity greater.

    Notes
    -----
    With the margin :math:`m \pm u_m` at the last value and the rate :math:`r \pm u_r` at which it
    goes, the moments at which zero lies just within the 95 % interval of what is left are

    .. math:: (m - r t)^2 = u_m^2 + (u_r t)^2

    (Fieller).  Where :math:`r \le u_r` no latest moment follows from it: the wheel may not wear.

    References
    ----------
    .. [1] E. C. Fieller, "Some problems in interval estimation", J. R. Stat. Soc. B 16, 1954.
    """
    towards = 1.0 if grows else -1.0
    margin = towards * (limit_mm - wear.level_mm)
    rate = towards * wear.per_day.value_mm
    u_margin, u_rate = wear.u95_mm, wear.per_day.u95_mm
    known = rate**2 - u_rate**2
    # Of the margin's own uncertainty where it is less than that: the limit may be met already.
    root = sqrt(max(known * u_margin**2 + (margin * u_rate) ** 2, 0.0))
    towards_it = margin * rate + root
    least = (margin**2 - u_margin**2) / towards_it if towards_it > 0.0 else inf
    return Forecast(
        limit_mm=limit_mm,
        margin_mm=margin,
        per_day_mm=rate,
        expected_day=wear.day + (margin / rate if rate > 0.0 else inf) if margin > 0 else wear.day,
        earliest_day=wear.day + least if margin > u_margin else wear.day,
        latest_day=_latest(wear, margin, rate, known, root),
    )


def _latest(wear: Wear, margin: float, rate: float, known: float, root: float) -> float:
    if margin <= -wear.u95_mm:
        return wear.day
    if not (rate > 0.0 and known > 0.0):
        return inf
    return wear.day + (margin * rate + root) / known
