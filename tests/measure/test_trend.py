"""Rates of wear and their intervals are right on wheels of known wear; jumps are told from wear
and from noise.  That passes are of the same wheel is taken for granted here."""

import numpy as np
import pytest

from measure import Alarm, Limit, Reading, Status, TrendPoint, difference, fit_trend, jump_between
from measure import spread as spread_of
from measure.gauging.uncertainty import COVERAGE_FACTOR


def points(days, values, u95=0.04):
    u95s = np.broadcast_to(u95, len(days))
    return [TrendPoint(*one) for one in zip(days, values, u95s, strict=True)]


def reading(value, u95=0.03, status=Status.OK):
    return Reading(value, u95, status, Alarm.NONE)


def test_even_wear_is_its_rate_to_the_last_bit():
    days = np.array([0.0, 3.0, 4.0, 11.0])
    trend = fit_trend(points(days, 1.0 + 0.02 * days))
    assert trend.per_day.value_mm == pytest.approx(0.02, abs=1e-12)
    assert trend.passes == 4
    by_pass = fit_trend(points(days, 1.0 + 0.1 * np.arange(4)))
    assert by_pass.per_pass.value_mm == pytest.approx(0.1, abs=1e-12)


def test_an_interval_of_a_rate_covers_the_truth_as_often_as_it_says(rng):
    days = np.array([0.0, 1.0, 2.5, 4.0, 7.0, 8.0])
    u95 = np.array([0.02, 0.05, 0.03, 0.04, 0.02, 0.06])
    trials = 2000
    held = 0
    for _ in range(trials):
        noise = rng.normal(size=6) * u95 / COVERAGE_FACTOR
        rate = fit_trend(points(days, 0.01 * days + noise, u95)).per_day
        held += abs(rate.value_mm - 0.01) <= rate.u95_mm
    # Never below 95 %: only a scatter beyond u95 widens the interval, and none narrows it. Five
    # standard deviations of 2000 draws are 2.4 %.
    assert held / trials > 0.95 - 0.024


def test_uneven_wear_widens_the_interval_as_it_scatters():
    days = np.arange(8.0)
    even = 0.02 * days
    rough = even + 0.5 * np.array([1, -1, 1, -1, 1, -1, 1, -1])
    assert fit_trend(points(days, rough)).scatter > 20.0
    assert (
        fit_trend(points(days, rough)).per_day.u95_mm
        > 20 * fit_trend(points(days, even)).per_day.u95_mm
    )


def test_passes_of_one_moment_have_no_rate_in_time_and_one_pass_no_trend():
    trend = fit_trend(points([5.0, 5.0], [1.0, 2.0]))
    assert trend.per_day is None
    assert trend.per_pass.value_mm == pytest.approx(1.0)
    assert trend.scatter is None
    assert fit_trend(points([5.0], [1.0])) is None


@pytest.mark.parametrize("u95", [0.0, -1.0, float("nan")])
def test_a_point_without_interval_is_refused(u95):
    with pytest.raises(ValueError, match="positive u95"):
        TrendPoint(0.0, 1.0, u95)


@pytest.mark.parametrize(
    ("change", "u95", "jumps"),
    [(0.3, 0.01, False), (0.6, 0.01, True), (-0.6, 0.01, True), (0.6, 0.4, False)],
)
def test_a_jump_is_beyond_its_limit_and_beyond_doubt(change, u95, jumps):
    before, after = points([0.0, 1.0], [2.0, 2.0 + change], u95)
    found = jump_between(before, after, Limit(high_mm=8.0, jump_mm=0.5))
    assert (found is not None) == jumps
    if jumps:
        assert found.change_mm == pytest.approx(change)
        assert found.u95_mm == pytest.approx(u95 * 2**0.5)


def test_a_limit_whose_jump_is_nothing_is_refused():
    with pytest.raises(ValueError, match="jump_mm"):
        Limit(jump_mm=0.0)


def test_a_difference_is_as_sure_as_its_parts_and_of_the_worse_status():
    found = difference(reading(28.5), reading(28.1, 0.04, Status.EXTRAPOLATED))
    assert found.value_mm == pytest.approx(0.4)
    assert found.u95_mm == pytest.approx(0.05)
    assert found.status is Status.EXTRAPOLATED
    assert difference(reading(28.5), Reading.missing()) is None


def test_the_spread_of_a_vehicle_names_its_extremes():
    found = spread_of([reading(28.0), Reading.missing(), reading(29.5), reading(27.5)])
    assert (found.greatest, found.smallest) == (2, 3)
    assert found.difference.value_mm == pytest.approx(2.0)
    assert spread_of([reading(28.0), Reading.missing()]) is None
