"""Shows that the wheels of a rig are measured while they pass as afterwards, to the last bit: with
a sensor that is late, lost a frame, recorded nothing, or was damaged in the end."""

import pytest
from followed_trackside import Trackside, damage, ensure_as_afterwards
from rig_recordings import INNER, OUTER, TRIGGERS_APART_NS, calibration_of, true_rig
from wheel_recordings import NEXT_WHEEL_MS, SAME_WHEEL_MS

from station.operations import utc_now
from station.store import Calibration, CalibrationState, RigCalibration, the


@pytest.fixture
def rig_ground(ground):
    with ground.store.change() as session:
        for sensor in (INNER, OUTER):
            row = the(session, Calibration, f"of-{sensor}")
            row.document = calibration_of(sensor).model_dump_json()
        session.add(
            RigCalibration(
                id="true",
                state=CalibrationState.READY,
                rig="wheel",
                created_at=utc_now(),
                document=true_rig().model_dump_json(),
            )
        )
    return ground


def roll_by_rig(trackside, shots, *, lost=(), late=None):
    """Write wheels of the same shots; `late` comes only after all of the other sensor's."""
    kept = []
    for number in range(3):
        for place, pictures in enumerate(shots):
            for skew, sensor in enumerate(trackside.sensors):
                time_ms = number * NEXT_WHEEL_MS + place * SAME_WHEEL_MS
                time_ms += skew * TRIGGERS_APART_NS / 1e6
                if (number, place, sensor) in lost:
                    continue
                kept.append((sensor, pictures[sensor], time_ms))
    for sensor, picture, time_ms in sorted(kept, key=lambda each: each[0] == late):
        trackside.write(sensor, picture, time_ms)
        trackside.turn(quiet=True)


@pytest.mark.parametrize("late", [None, OUTER])
def test_a_rig_is_followed_whichever_sensor_is_late(rig_ground, rig_shots, located, late):
    here = Trackside(rig_ground, (INNER, OUTER), rig="true")
    roll_by_rig(here, rig_shots[:1], lost=[(1, 0, OUTER)], late=late)
    assert here.frames == [[1], [2], [3]]
    here.finish()
    assert here.frames == [[1], [2], [3]]
    assert len(located) == 5
    ensure_as_afterwards(here)


def test_a_sensor_that_recorded_nothing_is_said_in_each_reading_in_the_end(rig_ground, rig_shots):
    here = Trackside(rig_ground, (INNER, OUTER), rig="true")
    for number in range(2):
        here.write(INNER, rig_shots[0][INNER], number * NEXT_WHEEL_MS)
        here.turn(quiet=True)
    assert here.frames == [[1], [2]]
    here.finish()
    assert here.frames == [[1], [2]]
    said = [each["wheel"]["quality"]["by_sensor"][OUTER] for each in here.seen.values()]
    assert [each["reason"] for each in said] == ["no frame was recorded"] * 2


def test_no_reading_rests_on_a_recording_of_which_nothing_was_saved(rig_ground, rig_shots):
    here = Trackside(rig_ground, (INNER, OUTER), rig="true")
    roll_by_rig(here, rig_shots[:1])
    here.frame[OUTER] = 0  # as what a crash left of it says
    here.finish()
    said = [each["wheel"]["quality"]["by_sensor"][OUTER] for each in here.seen.values()]
    assert [each["reason"] for each in said] == ["no frame was recorded"] * 3


def test_a_sensor_damaged_in_the_end_has_no_part_in_the_readings_before(rig_ground, rig_shots):
    here = Trackside(rig_ground, (INNER, OUTER), rig="true")
    roll_by_rig(here, rig_shots[:1])
    assert len(here.frames) == 3
    here.follower = here.new_follower()  # the worker was killed, and the disk failed
    for each in here.writers.values():
        each.finish({})
    damage(rig_ground.layout.root / f"{OUTER}.mcap", from_the_end=len(rig_shots[0][OUTER]) * 1000)
    here.measure()
    said = [each["wheel"]["quality"]["by_sensor"][OUTER] for each in here.seen.values()]
    assert ["damaged" in each["reason"] for each in said] == [True] * 3
    ensure_as_afterwards(here)
