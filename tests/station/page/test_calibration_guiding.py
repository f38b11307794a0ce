"""Guiding who takes calibration pictures, on real pictures of the demo station's sessions.

That the sentence read out can be followed by a person is not shown here.
"""

import contextlib
import os
import signal
import time
from dataclasses import replace

import numpy as np
import pytest
from demo_station_truth import BOARDS, RIGHT

from calib import Target, View
from station.documents import CalibrationDocument
from station.errors import RecordingUnreadable
from station.guiding import Demands, Guide, GuideLost, SessionSoFar, SessionWatch
from station.guiding.enough import Criterion, Demand
from station.guiding.guidance import guidance_of
from station.settings import ExposureSettings
from station.store import Calibration, Recording, Store

TARGET = BOARDS[RIGHT]
DEMANDS = Demands(fewest_poses=6)
PATIENCE_S = 60.0


@pytest.fixture(scope="module")
def kept(demo_data):
    """The first calibration of the right sensor, and the recording it was solved from."""
    store = Store.open(f"sqlite:///{demo_data.folder / 'data' / 'station.sqlite'}")
    with store.look() as session:
        row = session.get(Calibration, demo_data.told.calibrations["right-1"])
        (name,) = row.recording_ids["recordings"]
        path = demo_data.folder / "data" / session.get(Recording, name).path
    store.close()
    return row, path


@pytest.fixture(scope="module")
def watch(kept):
    row, recording = kept
    return SessionWatch(recording, Target.parse(row.target))


@pytest.fixture(scope="module")
def small(demo_data):
    """A session of two pictures."""
    sessions = demo_data.folder / "data" / "recordings" / "sessions"
    return SessionWatch(sessions / "right-too-few" / "right.mcap", TARGET)


@pytest.fixture(scope="module")
def seen(watch):
    return watch.go_on(SessionSoFar())


@pytest.fixture(scope="module")
def present(kept):
    return CalibrationDocument.model_validate_json(kept[0].document)


def first(seen, count):
    return replace(seen, seen=seen.seen[:count])


def by_demand(guidance):
    return {each.demand: each for each in guidance.criteria}


def test_every_picture_of_a_session_is_looked_at_once(watch, seen):
    assert len(seen.views) == len(seen.seen) >= 8
    assert all(view.stripe is not None for view in seen.views)
    assert watch.go_on(seen) == seen


def test_a_session_is_taken_up_where_it_was_left(watch, seen):
    told = watch.go_on(replace(first(seen, 0), next=seen.next))
    assert told.seen == ()


def test_frames_of_a_pose_that_is_not_whole_yet_wait(watch, seen):
    whole = seen.seen
    count = len(whole) // 2 + 1
    steps = tuple(ExposureSettings(exposure_us=100.0 + step) for step in range(count))
    told = replace(watch, exposures=steps).go_on(SessionSoFar())
    assert len(told.seen) == 1
    assert all(isinstance(each, View) for each in told.seen)


def test_a_picture_without_the_target_says_why(small):
    other = replace(small, target=replace(TARGET, rows=9, cols=11))
    told = other.go_on(SessionSoFar())
    guidance = guidance_of(told, other.target, DEMANDS)
    assert told.views == ()
    assert all("9x11" in pose.why for pose in guidance.poses)
    assert guidance.poses[0].dots == 0


def test_before_the_first_picture_the_calibration_in_force_tells_where_to_begin(present):
    guidance = guidance_of(SessionSoFar(), TARGET, DEMANDS, present)
    assert not guidance.enough
    assert guidance.next is not None
    assert 0.0 < guidance.next.across < 1.0
    assert 0.0 < guidance.next.down < 1.0


def test_without_any_calibration_nothing_is_promised_before_three_pictures(seen):
    guidance = guidance_of(first(seen, 2), TARGET, DEMANDS)
    assert guidance.next is None
    assert guidance.wanted_cells is None
    assert by_demand(guidance)[Demand.SHEET].value is None
    assert not guidance.enough


def test_more_pictures_leave_less_open(seen):
    few, every = (guidance_of(first(seen, count), TARGET, DEMANDS) for count in (4, len(seen.seen)))
    assert not few.enough
    assert by_demand(few)[Demand.POSES].value == 4
    sheet_few, sheet_all = (by_demand(each)[Demand.SHEET].value for each in (few, every))
    assert sheet_all < sheet_few
    assert by_demand(every)[Demand.FOCAL].met
    assert by_demand(every)[Demand.DOTS].value == pytest.approx(1.0, abs=0.3)


def test_more_poses_than_are_there_are_missing(seen):
    assert not guidance_of(seen, TARGET, Demands(fewest_poses=20)).enough
    with pytest.raises(ValueError, match="at least 3"):
        Demands(fewest_poses=2)


def test_a_pose_tells_how_the_target_stood(seen, present):
    guidance = guidance_of(seen, TARGET, DEMANDS)
    stood = {pose.image: pose.translation_mm for pose in present.poses}
    in_order = sorted(stood, key=lambda name: int(name.split("#")[1]))
    for pose, image in zip(guidance.poses, in_order, strict=True):
        # Of the board's first dot there, of its middle here.
        assert pose.depth_mm == pytest.approx(stood[image][2], abs=120.0)
        assert 0.0 <= pose.tilt_deg < 60.0


def test_pictures_that_give_no_calibration_say_why(seen):
    still = replace(seen, seen=tuple(replace(seen.views[0], name=f"copy {n}") for n in range(4)))
    guidance = guidance_of(still, TARGET, DEMANDS)
    assert guidance.unsolved
    assert not guidance.enough


def test_a_calibration_of_other_pictures_is_no_guide(seen, present):
    camera = present.camera.model_copy(update={"width": present.camera.width + 8})
    strange = present.model_copy(update={"camera": camera})
    assert guidance_of(first(seen, 1), TARGET, DEMANDS, strange).next is None


@pytest.fixture
def guide(tmp_path):
    guide = Guide("warning", tmp_path / "lock", idle_s=PATIENCE_S, patience_s=PATIENCE_S)
    yield guide
    guide.close()


def test_the_guide_tells_what_was_told_before_without_asking_again(guide, small, present):
    told = guide.guidance(small, DEMANDS, present)
    assert guide.guidance(small, DEMANDS, present) is told
    assert guide.guidance(small, DEMANDS, None) is not told


def test_a_guide_that_died_is_back_with_the_next_question(guide, small):
    guide.guidance(small, DEMANDS, None)
    first_pid = guide.pid
    os.kill(first_pid, signal.SIGKILL)
    with contextlib.suppress(GuideLost):  # it dies a moment later
        guide.guidance(small, DEMANDS, None)
    assert len(guide.guidance(small, DEMANDS, None).poses) == 2
    assert guide.pid != first_pid
    guide.close()
    assert guide.pid is None


def test_a_guide_that_does_not_answer_is_ended(tmp_path, small):
    hasty = Guide("warning", tmp_path / "lock", idle_s=PATIENCE_S, patience_s=0.01)
    with pytest.raises(GuideLost, match="no answer within"):
        hasty.guidance(small, DEMANDS, None)
    assert hasty.pid is None


def test_a_guide_that_nobody_asks_ends_by_itself(tmp_path, small):
    guide = Guide("warning", tmp_path / "lock", idle_s=0.1, patience_s=PATIENCE_S)
    guide.guidance(small, DEMANDS, None)
    until_s = time.monotonic() + PATIENCE_S
    while guide.pid is not None:
        assert time.monotonic() < until_s, "the process still waits"
        time.sleep(0.02)
    guide.close()


def test_a_damaged_recording_is_named_as_what_it_is(guide, small, tmp_path):
    damaged = tmp_path / "right.mcap"
    content = bytearray(small.recording.read_bytes())
    content[len(content) // 4] ^= 0xFF
    damaged.write_bytes(content)
    with pytest.raises(RecordingUnreadable):
        guide.guidance(SessionWatch(damaged, TARGET), DEMANDS, None)


def test_criteria_that_cannot_be_told_are_not_met():
    (poses, covered, *rest) = DEMANDS.criteria(6, None, None, np.empty((0, 2)))
    assert poses.met
    assert not covered.met
    assert not any(each.met for each in rest)


@pytest.mark.parametrize(
    ("at_least", "value", "met"),
    [(True, 5.0, False), (True, 6.0, True), (True, 7.0, True)]
    + [(False, 5.0, True), (False, 6.0, True), (False, 7.0, False), (False, None, False)],
)
def test_a_criterion_is_met_on_its_side_of_the_limit(at_least, value, met):
    assert Criterion(Demand.POSES, value, 6.0, at_least).met is met
