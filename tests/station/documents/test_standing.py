"""Shows that what a row keeps of a flange back's places tells the distance as the places do."""

import numpy as np
import pytest

from measure import Budget, Survey, TrackFrame, WheelPlace, back_to_back
from station.documents import StandingDocument

START_NS = 1_760_000_000_123_456_000
TRACK = TrackFrame.of_distance(1500.0, sigma_mm=0.1, sigma_turn_rad=1e-4)
CAUSES = 41


def places(rng, shots, *, ahead=1.0):
    return [
        WheelPlace(
            START_NS + 19_000_000 * shot,
            -70.0 + rng.normal(0.0, 0.05),
            Budget(0.03, rng.normal(0.0, 0.02, CAUSES)),
            (),
            back_at_mm=np.array([ahead * 364.0, 210.0 + shot]),
        )
        for shot in range(shots)
    ]


def through_a_row(places_seen):
    kept = StandingDocument.of(places_seen, Survey())
    return StandingDocument.model_validate_json(kept.model_dump_json()).places()


@pytest.mark.parametrize("shots", [1, 2, 6, 60])
def test_the_distance_from_rows_is_that_from_the_places(rng, shots):
    left, right = places(rng, shots), places(rng, shots, ahead=-1.0)
    exact = back_to_back(left, right, TRACK, fewest_pairs=1)
    found = back_to_back(through_a_row(left), through_a_row(right), TRACK, fewest_pairs=1)
    # Each number is kept to 0.1 um; 60 x 41 of them, rounded by 0.03 um each, move u95 by less.
    assert found.value_mm == pytest.approx(exact.value_mm, abs=3e-4)
    assert found.u95_mm == pytest.approx(exact.u95_mm, abs=3e-4)
    assert found.pairs == exact.pairs == shots


def test_a_row_keeps_no_more_causes_than_shots(rng):
    kept = StandingDocument.of(places(rng, 3), Survey())
    assert {len(back.shared_mm) for back in kept.backs} == {3}
    # As many as two readings with their status take.
    assert len(kept.model_dump_json()) < 600


def test_the_time_of_a_shot_is_kept_to_the_microsecond(rng):
    assert [each.time_ns for each in through_a_row(places(rng, 2))] == [
        START_NS,
        START_NS + 19_000_000,
    ]


@pytest.mark.parametrize("lacking", ["time", "back", "survey"])
def test_what_tells_nothing_is_not_kept(rng, lacking):
    (seen,) = places(rng, 1)
    place = WheelPlace(
        None if lacking == "time" else seen.time_ns,
        None if lacking == "back" else seen.back_mm,
        None if lacking == "back" else seen.back,
        (),
        None if lacking == "back" else seen.back_at_mm,
    )
    assert StandingDocument.of([place], None if lacking == "survey" else Survey()) is None
    assert StandingDocument.of([], Survey()) is None
