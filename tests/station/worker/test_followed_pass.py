"""Shows that a pass is measured while it is recorded, and that what stands in the end is, bit for
bit, what measuring the finished recordings gives: with files that go on in next ones, wheels
thought over too early, killed followers and files that a crash cut.  The pictures are rendered
wheels; time does not run but is told."""

import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from followed_trackside import PASS, Trackside, damage, ensure_as_afterwards
from wheel_recordings import FILE_FOR_EACH_FRAME, NEXT_WHEEL_MS, SAME_WHEEL_MS, views_of

from station.errors import StoreUnusable
from station.recording import active_path, recover
from station.scenes import WheelTruth
from station.store import Pass, PassState, the
from station.store.disposal import measured_recordings
from station.store.lists import measurements_page
from station.worker.following import PassFollower

OFFSETS_MM = (-20.0, 10.0)


@pytest.fixture(scope="module")
def wheels():
    """Return the pictures of two wheels."""
    rng = np.random.default_rng(7)
    truths = [WheelTruth("S1002", tread_wear_mm=wear_mm) for wear_mm in (1.0, 2.5)]
    return [views_of(each, OFFSETS_MM, rng, seed=3 + at) for at, each in enumerate(truths)]


def roll_by(trackside, wheels, *, quiet=()):
    """Write the wheels frame by frame, with a turn after each; quiet after frames (wheel, view)."""
    for number, views in enumerate(wheels):
        for place, picture in enumerate(views):
            time_ms = number * NEXT_WHEEL_MS + place * SAME_WHEEL_MS
            trackside.write("left", picture, time_ms)
            trackside.turn(quiet=(number, place) in quiet)


def test_a_wheel_is_read_while_its_pass_is_recorded_and_the_reading_stays(ground, wheels, located):
    here = Trackside(ground)
    roll_by(here, wheels, quiet=[(0, 1)])
    assert here.frames == [[1, 2]]
    early = dict(here.seen)
    here.turn(quiet=True)
    assert here.frames == [[1, 2], [3, 4]]
    at_the_end = dict(here.seen)
    here.finish()
    assert here.seen == at_the_end
    assert list(here.seen.items())[0] == next(iter(early.items()))
    assert len(located) == 4  # no frame was looked at twice
    ensure_as_afterwards(here)


def test_a_wheel_thought_over_too_early_is_read_anew_when_it_goes_on(ground, wheels):
    here = Trackside(ground)
    roll_by(here, wheels, quiet=[(0, 0)])
    assert here.frames == [[1, 2]]
    with ground.store.look() as session:
        assert len(measurements_page(session, limit=9).rows) == 1
    here.finish()
    assert here.frames == [[1, 2], [3, 4]]
    ensure_as_afterwards(here)


def test_a_recording_that_goes_on_in_next_files_is_followed_through_them(ground, wheels, located):
    here = Trackside(ground, rotation=FILE_FOR_EACH_FRAME)
    roll_by(here, wheels)
    assert here.frames == [[1, 2]]
    here.finish()
    assert len(located) == 4
    ensure_as_afterwards(here)


def test_a_follower_goes_on_where_a_killed_one_was(ground, wheels, located):
    here = Trackside(ground)
    for number, views in enumerate(wheels):
        for place, picture in enumerate(views):
            here.write("left", picture, number * NEXT_WHEEL_MS + place * SAME_WHEEL_MS)
        here.turn(quiet=True)
        here.follower = here.new_follower()
    before = dict(here.seen)
    here.turn(quiet=True)
    assert here.seen == before
    here.finish()
    assert here.seen == before
    # Each follower looks at the frames of the wheel that was not certain when it began.
    assert len(located) == 2 + 4 + 2
    ensure_as_afterwards(here)


def test_a_pass_that_nobody_followed_is_measured_whole(ground, wheels, located):
    here = Trackside(ground)
    for number, views in enumerate(wheels):
        for place, picture in enumerate(views):
            here.write("left", picture, number * NEXT_WHEEL_MS + place * SAME_WHEEL_MS)
    here.finish()
    assert len(located) == 4
    ensure_as_afterwards(here)


def test_readings_of_a_recording_that_a_crash_cut_are_made_anew(ground, wheels):
    """The disk lost frames that had been measured, and wheels with them."""
    here = Trackside(ground)
    roll_by(here, wheels)
    here.turn(quiet=True)
    (writer,) = here.writers.values()
    unfinished = active_path(ground.layout.root / "left.mcap")
    size = unfinished.stat().st_size
    writer._writer._file.abandon()
    with unfinished.open("r+b") as stream:
        stream.truncate(size * 3 // 8)  # in the middle of the second frame
    recover(unfinished)
    here.frame["left"] = 1
    here.measure()
    assert here.frames == [[1]]
    ensure_as_afterwards(here)


def test_readings_by_another_reference_do_not_stand_beside_those_of_the_settings(ground, wheels):
    here = Trackside(ground)
    roll_by(here, wheels)
    other = ground.settings.model_copy(update={"reference": "LMA"})
    here.context = replace(here.context, settings=other)
    here.finish()
    assert {each["reference"] for each in here.seen.values()} == {"LMA"}
    assert here.frames == [[1, 2], [3, 4]]


def test_a_frame_that_is_damaged_leaves_the_pass_to_the_job(ground, wheels):
    here = Trackside(ground)
    roll_by(here, wheels[:1])
    damage(active_path(ground.layout.root / "left.mcap"), from_the_end=1000)
    follower = here.follower = here.new_follower()
    here.turn(quiet=True)
    assert here.seen == {}
    assert follower._followed == {PASS: []}


def test_a_pass_that_failed_is_let_go_of_and_nothing_is_kept_of_it_any_more(ground, wheels):
    here = Trackside(ground)
    here.write("left", wheels[0][0], 0.0)
    here.turn()
    with ground.store.change() as session:
        the(session, Pass, PASS).state = PassState.FAILED
    here.turn(quiet=True)
    assert (here.seen, here.follower._followed) == ({}, {})


def test_the_thread_follows_by_itself_past_a_store_that_is_away_for_a_moment(
    ground, wheels, monkeypatch
):
    here = Trackside(ground)
    follower = PassFollower(here.context)
    look, away = type(ground.store).look, [True]

    def look_or_not(store):
        if away and threading.current_thread() is follower._thread:
            away.pop()
            raise StoreUnusable("the store is away")
        return look(store)

    monkeypatch.setattr(type(ground.store), "look", look_or_not)
    follower.start()
    for place, picture in enumerate(wheels[0]):
        here.write("left", picture, place * SAME_WHEEL_MS)
    deadline = time.monotonic() + 30.0
    while here.frames != [[1, 2]]:
        assert time.monotonic() < deadline, here.frames
        time.sleep(0.02)
    follower.stop()
    assert (away, follower._followed) == ([], {})


def test_a_recording_that_cannot_be_measured_to_its_end_keeps_its_readings_and_is_kept(
    ground, wheels
):
    """Of two sensors one is damaged behind its first wheel; the pass is done by the other."""
    here = Trackside(ground, ("left", "right"))
    for number, views in enumerate(wheels):
        for place, picture in enumerate(views):
            for sensor in here.sensors:
                here.write(sensor, picture, number * NEXT_WHEEL_MS + place * SAME_WHEEL_MS)
        here.turn(quiet=True)
        here.follower = here.new_follower()
    before = dict(here.seen)
    for each in here.writers.values():
        each.finish({})
    damage(ground.layout.root / "right.mcap", from_the_end=len(wheels[1][1]) * 1000)
    here.follower.stop()
    here.measure()
    assert "damaged" in here.results[1]["refused"]
    assert here.seen == before
    with ground.store.look() as session:
        assert [each.sensor for each in measured_recordings(session)] == ["left"]
