"""Shows how readings given early are made certain, or withdrawn for the right ones."""

from datetime import UTC, datetime

import pytest

from station.store import (
    Calibration,
    CalibrationState,
    EarlyReading,
    Following,
    Measurement,
    Pass,
    PassState,
    Recording,
)
from station.store.lists import measurements_page
from station.store.measured import (
    end_following,
    followings_of,
    forget_followed,
    keep_followed,
    note_followed,
    profiles_of,
)

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)
BOTH = ["inner", "outer"]


@pytest.fixture
def recorded(store):
    """A store with a pass that is being recorded, by two sensors."""
    with store.change() as session:
        session.add(Pass(id="p", state=PassState.RECORDING, opened_at=NOON))
        for sensor in BOTH:
            session.add(
                Calibration(
                    id=f"of-{sensor}",
                    state=CalibrationState.READY,
                    sensor=sensor,
                    target="dots:7x8:12",
                    method="joint",
                    recording_ids={},
                    created_at=NOON,
                    job_id="j",
                )
            )
        session.flush()
        for sensor in BOTH:
            session.add(
                Recording(
                    id=sensor,
                    sensor=sensor,
                    pass_id="p",
                    path=f"{sensor}.mcap",
                    opened_at=NOON,
                    calibration_id=f"of-{sensor}",
                )
            )
    return store


def reading(*frames, recording="inner", frame=None, **said):
    return Measurement(
        recording_id=recording,
        frame=frames[0] if frame is None else frame,
        calibration_id=f"of-{recording}",
        sensor=recording,
        pass_id="p",
        reference="S1002",
        regime="practice",
        software="treadline 0",
        measured_at=NOON,
        wheel={"frames": list(frames), "profile": {"d_mm": [1.0]}, **said},
    )


def keep(store, certain=(), early=(), recordings=BOTH):
    with store.change() as session:
        return keep_followed(session, recordings, list(certain), list(early))


def kept(store):
    """Return id and frames of all readings, and the ids of those that are early."""
    with store.look() as session:
        rows = measurements_page(session, limit=99).rows
        assert profiles_of(session, rows).keys() == {row.id for row in rows}
        early = {row.measurement_id for row in session.query(EarlyReading)}
        return {row.id: row.wheel["frames"] for row in rows}, early


def test_an_early_reading_that_proves_right_is_the_same_row(recorded):
    keep(recorded, early=[reading(1, 2)])
    before, early = kept(recorded)
    assert (list(before.values()), early) == ([[1, 2]], set(before))
    assert keep(recorded, certain=[reading(1, 2)]) == 0
    assert kept(recorded) == (before, set())


def test_an_early_reading_that_went_on_is_withdrawn_for_the_whole_one(recorded):
    keep(recorded, early=[reading(1, 2)])
    assert keep(recorded, early=[reading(1, 2, 3)]) == 1
    assert keep(recorded, certain=[reading(1, 2, 3, 4, frame=1)], early=[reading(9)]) == 1
    wheels, early = kept(recorded)
    assert list(wheels.values()) == [[1, 2, 3, 4], [9]]
    assert early == {max(wheels)}


def test_readings_behind_one_that_changed_are_kept_anew_so_that_they_stay_in_order(recorded):
    keep(recorded, early=[reading(1), reading(5, recording="outer"), reading(9)])
    assert keep(recorded, early=[reading(1), reading(5, 6, recording="outer"), reading(9)]) == 2
    wheels, early = kept(recorded)
    assert list(wheels.values()) == [[1], [5, 6], [9]]
    assert early == set(wheels)


def test_what_is_said_of_a_wheel_counts_as_well_as_its_frames(recorded):
    keep(recorded, early=[reading(1, quality="without the other sensor")])
    assert keep(recorded, early=[reading(1, quality="with it")]) == 1


def test_certain_readings_and_those_of_other_recordings_are_left_alone(recorded):
    keep(recorded, certain=[reading(1)])
    keep(recorded, early=[reading(1, recording="outer")], recordings=["outer"])
    assert keep(recorded, early=[reading(5)], recordings=["inner"]) == 0
    assert keep(recorded, early=[], recordings=["inner"]) == 1
    assert list(kept(recorded)[0].values()) == [[1], [1]]


def following(recording, frames):
    return Following(
        recording_id=recording,
        reference="S1002",
        regime="practice",
        software="treadline 0",
        part=1,
        offset_bytes=1 << 40,
        frames=frames,
        shown_before=False,
    )


def test_the_last_note_of_how_far_a_recording_was_followed_counts(recorded):
    for frames in (3, 7):
        with recorded.change() as session:
            note_followed(session, [following("inner", frames), following("outer", frames + 1)])
    with recorded.look() as session:
        assert [row.frames for row in followings_of(session, BOTH)] == [7, 8]
        assert [row.offset_bytes for row in followings_of(session, ["inner"])] == [1 << 40]


def test_the_end_of_following_leaves_the_readings_as_ordinary_ones(recorded):
    keep(recorded, certain=[reading(1)], early=[reading(5)])
    with recorded.change() as session:
        note_followed(session, [following("inner", 3)])
        end_following(session, BOTH)
        assert followings_of(session, BOTH) == []
    wheels, early = kept(recorded)
    assert (list(wheels.values()), early) == ([[1], [5]], set())


def test_what_was_followed_is_forgotten_with_all_its_readings_and_nothing_else(recorded):
    keep(recorded, certain=[reading(1)], early=[reading(5)])
    keep(recorded, certain=[reading(1, recording="outer")], recordings=["outer"])
    with recorded.change() as session:
        note_followed(session, [following("inner", 3)])
    with recorded.change() as session:
        assert forget_followed(session, BOTH) == 2
    with recorded.look() as session:
        assert [row.recording_id for row in measurements_page(session, limit=9).rows] == ["outer"]
        assert followings_of(session, BOTH) == []
