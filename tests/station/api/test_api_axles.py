"""Shows what a controller gets of the distance between the flange backs of axles.  The store and
the steps of the worker are real; only what it reads out of recordings is a double."""

from datetime import timedelta

import pytest
from test_api_trains import AXLES_S, NOON, Trackside, wheel

from station.back_to_back import NO_TRACK
from station.documents import BackDocument, StandingDocument
from station.settings import LimitsSettings, TrackSettings
from station.store import Measurement

SHOT_S = 0.019
TRACK = TrackSettings(distance_mm=1500.0, sigma_distance_mm=0.05, sigma_turn_rad=1e-4)
TSI = LimitsSettings(preset="tsi")


@pytest.fixture
def trackside(served, call):
    return Trackside(served, call)


def standing(at_s, ahead, back_mm, shots):
    return StandingDocument(
        sigma_axle_direction_rad=5e-4,
        backs=tuple(
            BackDocument(
                time=NOON + timedelta(seconds=at_s + SHOT_S * shot),
                back_mm=back_mm,
                at_mm=(ahead * 364.0, 210.0),
                single_mm=0.05,
                shared_mm=(0.02,),
            )
            for shot in range(shots)
        ),
    )


def side(sensor, *, backs_mm=(-70.0,) * 4, shots=2):
    """One wheel an axle; of those whose flange back is None it was not seen."""
    ahead = 1.0 if sensor == "left" else -1.0
    wheels = []
    for number, (at_s, back_mm) in enumerate(zip(AXLES_S, backs_mm, strict=True), start=1):
        row = wheel(sensor, number, at_s, tread_wear=1.0)
        seen = None if back_mm is None else standing(at_s, ahead, back_mm, shots)
        wheels.append(row.model_copy(update={"standing": seen}))
    return wheels


def test_axles_have_their_distance_beside_the_differences_of_their_wheels(trackside):
    body = trackside.roll(
        "p1", side("left"), side("right", backs_mm=(-70.0, -69.0, None, -65.0)), track=TRACK
    )
    found = [axle["back_to_back"] for axle in body["axles"]]
    assert [each["value"] for each in found] == [
        pytest.approx(1360.0),
        pytest.approx(1361.0),
        None,
        pytest.approx(1365.0),
    ]
    assert [each["alarm"] for each in found] == ["none", "none", "unknown", "alarm"]
    assert [each["pairs"] for each in found] == [2, 2, 0, 2]
    assert found[2]["reason"].startswith("the right wheel has no flange back")
    assert (found[0]["status"], found[0]["reason"]) == ("ok", None)
    assert body["no_back_to_back"] is None
    assert "tread_wear" in body["axles"][0]["differences"]


def test_an_axle_beyond_its_limit_is_an_alarm_of_no_side(trackside):
    body = trackside.roll(
        "p1",
        side("left"),
        side("right", backs_mm=(-70.0, -70.0, -70.0, -65.0)),
        track=TRACK,
        limits=TSI,
        consist=["w1", "w2", "w3", "w4"],
    )
    (alarm,) = body["alarms"]
    u95 = body["axles"][3]["back_to_back"]["u95"]
    assert (alarm["kind"], alarm["level"], alarm["quantity"]) == ("limit", "alarm", "back_to_back")
    assert (alarm["number"], alarm["side"], alarm["wheelset"]) == (4, None, "w4")
    assert alarm["text"] == (
        f"axle 4: back_to_back 1365.00 ± {u95:.2f} mm is beyond its limit (tsi)"
    )


def test_without_a_track_it_is_said_once_that_no_axle_has_a_distance(trackside):
    body = trackside.roll("p1", side("left"), side("right"))
    assert {axle["back_to_back"] for axle in body["axles"]} == {None}
    assert body["no_back_to_back"] == NO_TRACK


def test_of_one_pair_alone_there_is_a_distance_only_where_the_settings_allow_it(trackside):
    one = {"shots": 1}
    body = trackside.roll("p1", side("left", **one), side("right", **one), track=TRACK)
    assert body["axles"][0]["back_to_back"]["reason"].endswith("at one time: 1, needed: 2")
    alone = TRACK.model_copy(update={"fewest_pairs": 1})
    body = trackside.roll("p2", side("left", **one), side("right", **one), track=alone)
    assert body["axles"][0]["back_to_back"]["value"] == pytest.approx(1360.0)


def test_wheels_kept_before_rows_held_their_flange_backs_give_no_distance(trackside, served):
    plain = [
        [wheel(sensor, number, at_s) for number, at_s in enumerate(AXLES_S, start=1)]
        for sensor in ("left", "right")
    ]
    body = trackside.roll("p1", *plain, track=TRACK)
    with served.store.look() as session:
        assert all("standing" not in row.wheel for row in session.query(Measurement))
    assert body["axles"][0]["back_to_back"]["reason"].startswith("the left wheel has no flange")
