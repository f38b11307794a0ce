"""Shows that a wheel's wear and what a station adds to it are told apart, and how surely.

Errors within a station are simulated wholly shared or wholly independent, the two ends of what is.
"""

import numpy as np
import pytest

from station.fleet import StationValue, station_agreement
from station.fleet.wear import WEAR_SIGMA_MM_PER_DAY

U95 = 0.05


def values(station, days, offset=0.0, rate=0.004, level=28.0, noise=None):
    noise = np.zeros(len(days)) if noise is None else noise
    return [
        StationValue(station, day, level + rate * day + offset + error, U95)
        for day, error in zip(days, noise, strict=True)
    ]


def test_wear_and_offset_come_out_exactly_of_exact_values():
    found = station_agreement([
        *values("a", np.arange(0.0, 400.0, 10.0)),
        *values("b", np.arange(5.0, 400.0, 20.0), offset=0.3),
    ])
    assert found.held_against == "a"
    # What is known of wear beforehand pulls the rate by its share: 1e-3 of it over a year.
    assert found.per_day.value_mm == pytest.approx(0.004, rel=1e-3)
    (offset,) = found.offsets
    assert offset.offset_mm == pytest.approx(0.3, abs=1e-4)
    assert not offset.agrees
    assert offset.u95_mm == pytest.approx(np.hypot(U95, U95), rel=0.01)


def test_one_value_each_tells_as_much_as_wear_leaves_open():
    near = station_agreement([*values("a", [0.0]), *values("b", [1.0], offset=0.06)])
    far = station_agreement([*values("a", [0.0]), *values("b", [100.0], offset=0.06)])
    assert near.offsets[0].u95_mm == pytest.approx(np.hypot(U95, U95), rel=0.05)
    assert far.offsets[0].u95_mm > 1.9 * WEAR_SIGMA_MM_PER_DAY * 100.0
    assert far.offsets[0].agrees


def test_a_station_alone_is_held_against_none():
    assert station_agreement(values("a", [0.0, 1.0, 2.0])) is None
    assert station_agreement([]) is None


def test_the_level_of_the_values_costs_no_digits():
    days = np.arange(0.0, 100.0, 5.0)
    one, two = (
        station_agreement([*values("a", days, level=at), *values("b", days, 0.1, level=at)])
        for at in (0.0, 1000.0)
    )
    assert one.offsets[0].offset_mm == pytest.approx(two.offsets[0].offset_mm, abs=1e-9)


@pytest.mark.parametrize("shared", [True, False])
def test_stations_whose_u95_is_right_agree_in_95_of_100(rng, shared):
    agree, draws = 0, 400
    days = {"a": np.arange(0.0, 60.0, 4.0), "b": np.arange(20.0, 90.0, 7.0)}
    for _ in range(draws):
        drawn = [
            value
            for name, at in days.items()
            for value in values(name, at, noise=errors(rng, len(at), shared))
        ]
        agree += station_agreement(drawn).offsets[0].agrees
    # Of 400 draws at 95 %, fewer than 367 come once in 400.
    assert agree >= 367


def errors(rng, count, shared):
    sigma = U95 / 1.96
    return np.full(count, rng.normal(0.0, sigma)) if shared else rng.normal(0.0, sigma, count)


@pytest.mark.parametrize("bad", [(np.nan, 1.0, 0.1), (0.0, np.inf, 0.1), (0.0, 1.0, 0.0)])
def test_a_value_without_time_or_uncertainty_is_refused(bad):
    with pytest.raises(ValueError, match="positive u95"):
        StationValue("a", *bad)
