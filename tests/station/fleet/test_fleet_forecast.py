"""Shows that the day at which a wheel meets its limit is foretold, and how surely.

Wear is simulated even and errors normal; a wheel that wears otherwise is not foretold.
"""

from math import inf

import numpy as np
import pytest

from measure import Rate
from station.fleet import StationValue, Wear, forecast_of, wear_of

DAYS = np.arange(0.0, 300.0, 15.0)


def wear(level=29.0, rate=0.01, u95=0.05, u_rate=0.002):
    return Wear("a", 0.0, 100.0, level, u95, Rate(rate, u_rate), {})


def values(rate, noise, u95=0.1):
    drawn = zip(DAYS, noise, strict=True)
    return [StationValue("a", day, 28.0 + rate * day + error, u95) for day, error in drawn]


def test_the_line_meets_the_limit_where_margin_and_rate_say():
    found = forecast_of(wear(), 30.0, grows=True)
    assert (found.margin_mm, found.expected_day) == (1.0, pytest.approx(200.0))
    assert 100.0 < found.earliest_day < 200.0 < found.latest_day < inf
    assert found.sure


def test_a_quantity_that_wear_lessens_is_foretold_alike():
    grown = forecast_of(wear(29.0, 0.01), 30.0, grows=True)
    thinned = forecast_of(wear(29.0, -0.01), 28.0, grows=False)
    assert thinned.expected_day == pytest.approx(grown.expected_day)
    assert thinned.latest_day == pytest.approx(grown.latest_day)


def test_a_rate_that_may_be_none_names_an_earliest_day_and_no_latest():
    found = forecast_of(wear(rate=0.001), 30.0, grows=True)
    assert 100.0 < found.earliest_day < found.expected_day < inf
    assert found.latest_day == inf
    assert not found.sure


def test_a_wheel_that_wears_away_from_its_limit_never_meets_it():
    found = forecast_of(wear(rate=-0.01), 30.0, grows=True)
    assert (found.earliest_day, found.expected_day, found.latest_day) == (inf, inf, inf)


@pytest.mark.parametrize(("level", "latest"), [(30.2, 100.0), (30.01, None)])
def test_a_wheel_at_its_limit_is_there_at_its_last_value(level, latest):
    found = forecast_of(wear(level), 30.0, grows=True)
    assert (found.earliest_day, found.expected_day) == (100.0, 100.0)
    assert found.latest_day > 100.0 if latest is None else found.latest_day == latest


def test_the_interval_holds_the_true_day_in_95_of_100_draws(rng):
    rate, limit, held, draws = 0.01, 33.0, 0, 400
    true_day = (limit - 28.0) / rate
    for _ in range(draws):
        # Half of the variance is the calibration's, the same in all values.
        shared, own = rng.normal(0.0, 0.1 / 1.96 / 2**0.5, 2 * len(DAYS)).reshape(2, -1)
        noise = shared[0] + own
        found = forecast_of(wear_of(values(rate, noise)), limit, grows=True)
        held += found.earliest_day <= true_day <= found.latest_day
    # Of 400 draws at 95 %, fewer than 367 come once in 400.
    assert held >= 367


def test_values_that_scatter_more_than_their_u95_make_the_rate_less_sure(rng):
    noise = rng.normal(0.0, 0.3, len(DAYS))
    calm = wear_of(values(0.01, np.zeros(len(DAYS)), u95=0.05))
    wild = wear_of(values(0.01, noise, u95=0.05))
    assert wild.per_day.u95_mm > 5.0 * calm.per_day.u95_mm


def test_one_value_tells_no_wear():
    assert wear_of([StationValue("a", 0.0, 28.0, 0.1)]) is None
