"""A diameter is given where sheets and survey support it, holds the truth as often as it says, and
is missing with a reason everywhere else.  Points are drawn from geometry: what a renderer or a
worn tread does to a point on the tape circle is not asked here."""

from dataclasses import replace

import numpy as np
import pytest

from measure import Diameter, Limits, Status, Survey, TreadPoint, WheelPlace, wheel_diameter
from measure.quantities import Reading

SURVEY = Survey()
NOISE_MM = 0.02
SHIFT_MM, TURN_RAD = 0.02, 1e-4
CAMERA_MM = 400.0
BOUNCE_MM = 0.05
# Degrees below the axle; ahead of it, or behind where negative.
OPPOSITE = (15.0, -45.0)
THREE = (20.0, 60.0, -20.0)
COPLANAR = (30.0, 30.0)


def direction(degrees):
    angle = np.radians(abs(degrees))
    return np.array([np.sign(degrees) * np.cos(angle), -np.sin(angle)])


def on_sheet(degrees, centre, radius):
    """Where a sheet, which runs through the axle of a nominal wheel at x = 0, meets the tread."""
    hub, along = np.array([0.0, SURVEY.wheel_radius_mm]), direction(degrees)
    ahead = (centre - hub) @ along
    return hub + along * (ahead + np.sqrt(ahead**2 - (centre - hub) @ (centre - hub) + radius**2))


def causes(number, count, degrees, place):
    """Motion of a point by its sheet's own pose, (2, 3 K); the first sheet carries the frame."""
    motion = np.zeros((2, 3 * count))
    if number > 0:
        camera = np.array([0.0, SURVEY.wheel_radius_mm]) + direction(degrees) * (420.0 + CAMERA_MM)
        arm = place - camera
        motion[:, 3 * number : 3 * number + 2] = np.eye(2) * SHIFT_MM
        motion[:, 3 * number + 2] = TURN_RAD * np.array([-arm[1], arm[0]])
    return motion


def rolled_past(rng, sheets, radius, *, shots=5, way=60.0, survey=SURVEY, noise=1.0):
    """Places of one wheel, in error as the survey and the columns say, `noise` times."""
    common = noise * rng.normal(size=3 * len(sheets))
    height = noise * rng.normal() * survey.sigma_height_mm
    climb = noise * rng.normal() * survey.sigma_axle_direction_rad
    places = []
    for number, x in enumerate(np.linspace(-way, way, shots)):
        bounce = noise * rng.normal() * BOUNCE_MM
        centre = np.array([x, radius + height + bounce + climb * x])
        treads = []
        for k, degrees in enumerate(sheets):
            place = on_sheet(degrees, centre, radius)
            motion = causes(k, len(sheets), degrees, place)
            outward = (place - centre) / radius
            seen = place + motion @ common + noise * rng.normal() * NOISE_MM * outward
            treads.append(TreadPoint(f"sensor-{k}", seen, NOISE_MM, motion))
        places.append(WheelPlace(20_000_000 * number, None, None, tuple(treads)))
    return places


def displaced(places, shot, by_mm):
    """The places with one sheet's point of one shot off along its radius, roughly."""
    tread = places[shot].treads[0]
    axle = np.array([0.0, SURVEY.wheel_radius_mm])
    outward = (tread.place_mm - axle) / np.linalg.norm(tread.place_mm - axle)
    wrong = replace(tread, place_mm=tread.place_mm + by_mm * outward)
    changed = replace(places[shot], treads=(wrong, *places[shot].treads[1:]))
    return [*places[:shot], changed, *places[shot + 1 :]]


@pytest.mark.parametrize("sheets", [OPPOSITE, THREE, (10.0, -10.0)])
@pytest.mark.parametrize("radius", [400.0, 420.0, 433.0])
def test_exact_points_give_the_diameter_whatever_the_nominal_one_is(rng, sheets, radius):
    found = wheel_diameter(rolled_past(rng, sheets, radius, noise=0.0), SURVEY, most_u95_mm=9.0)
    # What is left is where Gauss-Newton stops, 1e-6 mm of step.
    assert found.value_mm == pytest.approx(2.0 * radius, abs=1e-5)
    assert found.status is Status.OK
    assert found.sections == 5


@pytest.mark.parametrize("sheets", [(30.0,), COPLANAR, (22.5, 37.5), (15.0, 45.0), (30.0, -30.0)])
@pytest.mark.parametrize("shots", [3, 10])
def test_sheets_that_do_not_tell_the_radius_give_no_diameter(rng, sheets, shots):
    found = wheel_diameter(rolled_past(rng, sheets, 424.0, shots=shots), SURVEY)
    assert found.status is Status.MISSING
    assert found.value_mm is None


def test_coplanar_sheets_are_told_to_be_so_and_what_would_help(rng):
    found = wheel_diameter(rolled_past(rng, COPLANAR, 424.0), SURVEY)
    assert found.share < 0.1
    assert found.reason.startswith("the sheets meet the wheel 0 degrees apart")
    assert "ahead of the axle and behind" in found.reason


def test_a_radius_that_hangs_on_the_height_of_the_rail_says_so_and_a_better_survey_gives_it(rng):
    places = rolled_past(rng, (30.0, -30.0), 424.0, noise=0.0)
    found = wheel_diameter(places, SURVEY)
    assert "height over the rail is known to 1 mm" in found.reason
    close = wheel_diameter(places, Survey(sigma_height_mm=0.1))
    assert close.value_mm == pytest.approx(848.0, abs=1e-5)
    # Symmetric sheets 30 degrees down: radius and height err alike, so the diameter twice 0.1.
    assert 1.96 * 2.0 * 0.1 < close.u95_mm < 1.96 * 2.0 * 0.12


def test_sheets_apart_on_one_side_want_a_longer_way(rng):
    found = wheel_diameter(rolled_past(rng, (7.5, 52.5), 424.0, way=25.0), SURVEY)
    assert "farther apart around the wheel than 4" in found.reason
    assert "longer way" in found.reason


def test_two_sections_cannot_check_each_other(rng):
    found = wheel_diameter(rolled_past(rng, THREE, 424.0, shots=2), SURVEY)
    assert found.reason.startswith("2 of 2 shots")


@pytest.mark.parametrize(("sheets", "height_mm"), [(OPPOSITE, 1.0), (THREE, 1.0), ((20, -20), 0.2)])
def test_an_interval_of_a_diameter_holds_the_truth_as_often_as_it_says(rng, sheets, height_mm):
    survey = Survey(sigma_height_mm=height_mm)
    inside = []
    for _ in range(400):
        radius = 420.0 + 10.0 * rng.normal()
        found = wheel_diameter(
            rolled_past(rng, sheets, radius, survey=survey), survey, most_u95_mm=9.0
        )
        if found.value_mm is not None:
            inside.append(abs(found.value_mm - 2.0 * radius) <= found.u95_mm)
    # One in a hundred may be suspected of a contradiction; three standard deviations of 400 draws
    # are 1.5 %. Of the share inside, two standard deviations are 2.2 %.
    assert len(inside) >= 390
    assert 0.928 <= np.mean(inside) <= 0.972


@pytest.mark.parametrize("sheets", [OPPOSITE, THREE])
@pytest.mark.parametrize("shots", [3, 4, 8])
def test_one_point_that_is_grossly_wrong_is_never_silent(rng, sheets, shots):
    for trial in range(30):
        places = rolled_past(rng, sheets, 424.0, shots=shots)
        off = wheel_diameter(
            displaced(places, trial % shots, 2.0 * (-1) ** trial), SURVEY, most_u95_mm=9.0
        )
        # 4 standard deviations: of 180 draws none is farther off by chance.
        assert off.value_mm is None or abs(off.value_mm - 848.0) < 4.0 / 1.96 * off.u95_mm
        if off.value_mm is not None:
            assert off.sections < shots


def test_points_on_no_wheel_give_a_reason_and_no_number(rng):
    places = rolled_past(rng, THREE, 424.0)
    lost = [
        replace(
            place,
            treads=tuple(replace(t, place_mm=t.place_mm * [1.0, -9.0]) for t in place.treads),
        )
        for place in places
    ]
    found = wheel_diameter(lost, SURVEY)
    assert found.status is Status.MISSING
    assert "circle" in found.reason


def test_a_shot_with_one_sheet_changes_nothing(rng):
    places = rolled_past(rng, THREE, 424.0)
    alone = replace(places[2], treads=places[2].treads[:1])
    assert wheel_diameter([*places, alone], SURVEY) == wheel_diameter(places, SURVEY)


def test_the_diameter_is_the_same_from_the_other_side_of_the_wheel(rng):
    places = rolled_past(rng, THREE, 424.0)
    mirror = np.diag([-1.0, 1.0])
    mirrored = [
        replace(
            place,
            treads=tuple(
                replace(tread, place_mm=mirror @ tread.place_mm, shared_mm=mirror @ tread.shared_mm)
                for tread in place.treads
            ),
        )
        for place in places
    ]
    found, other = wheel_diameter(places, SURVEY), wheel_diameter(mirrored, SURVEY)
    assert other.value_mm == pytest.approx(found.value_mm, abs=1e-6)
    assert other.u95_mm == pytest.approx(found.u95_mm, rel=1e-6)


def test_the_survey_decides_whether_there_is_a_diameter_and_never_pulls_it(rng):
    places = rolled_past(rng, THREE, 424.0)
    loose = wheel_diameter(places, Survey(sigma_radius_mm=10.0))
    tight = wheel_diameter(places, Survey(sigma_radius_mm=1.0, wheel_radius_mm=421.0))
    assert tight.value_mm == pytest.approx(loose.value_mm, abs=1e-5)
    assert tight.share < loose.share
    close = wheel_diameter(places, Survey(sigma_radius_mm=0.03))
    assert close.status is Status.MISSING
    assert "% of what is known of its radius (survey: 0.03 mm)" in close.reason


def test_a_diameter_is_a_reading_beside_the_others(rng):
    found = wheel_diameter(rolled_past(rng, THREE, 424.0), SURVEY)
    reading = found.reading(Limits.default())
    assert (reading.value, reading.u95) == (found.value_mm, found.u95_mm)
    assert Diameter.missing("why").reading(Limits.default()) == Reading.missing()


def test_a_diameter_that_contradicts_itself_is_refused():
    with pytest.raises(ValueError, match="missing with a reason"):
        Diameter(850.0, None, Status.OK, 3, 1.0)
    with pytest.raises(ValueError, match="missing with a reason"):
        Diameter(None, None, Status.MISSING, 3, 1.0)
