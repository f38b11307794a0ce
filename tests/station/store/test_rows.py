"""Shows what the store keeps once, in which order it lists, and which updates it refuses."""

from datetime import UTC, datetime, timedelta

import pytest

from station.errors import InputUnusable, StateConflict, VersionConflict, VersionMissing
from station.store import (
    Actor,
    Calibration,
    CalibrationState,
    Job,
    JobKind,
    JobState,
    Measurement,
    Recording,
    RigCalibration,
    activate,
    active,
    add_job,
    end,
    report_progress,
    start,
    the,
)
from station.store.callers import Scope, add_key, any_key, caller_of
from station.store.lists import measurements_page, recordings_page
from station.store.measured import add_measurements, profiles_of
from station.store.tables import Key
from station.store.watched import frame_totals

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)


def a_calibration(calibration_id, *, sensor="left", state=CalibrationState.READY):
    return Calibration(
        id=calibration_id,
        state=state,
        sensor=sensor,
        target="dots:7x8:12",
        method="joint",
        recording_ids={"recordings": [], "laser_off": []},
        created_at=NOON,
        job_id="j",
    )


def a_recording(recording_id, minutes=0, **counts):
    opened = NOON + timedelta(minutes=minutes)
    return Recording(id=recording_id, sensor="left", path="x", opened_at=opened, **counts)


def a_measurement(frame, *, calibration="c1", sensor="left"):
    return Measurement(
        recording_id="r1",
        frame=frame,
        calibration_id=calibration,
        sensor=sensor,
        reference="S1002",
        software="treadline 0",
        measured_at=NOON,
        wheel={"frame": frame},
    )


@pytest.fixture
def filled(store):
    with store.change() as session:
        session.add_all([a_calibration("c1"), a_calibration("c2"), a_recording("r1")])
    return store


def test_a_wheel_is_kept_once_per_recording_frame_and_calibration(filled):
    with filled.change() as session:
        assert add_measurements(session, [a_measurement(1), a_measurement(2)]) == 2
    with filled.change() as session:
        again = a_measurement(2)
        again.wheel = {"frame": "another"}
        assert add_measurements(session, [again, a_measurement(3)]) == 1
        assert add_measurements(session, [a_measurement(2, calibration="c2")]) == 1
        assert add_measurements(session, []) == 0
    with filled.look() as session:
        rows = measurements_page(session, limit=10).rows
    assert [(row.frame, row.calibration_id) for row in rows] == [
        (1, "c1"),
        (2, "c1"),
        (3, "c1"),
        (2, "c2"),
    ]
    assert rows[1].wheel == {"frame": 2}


def test_a_wheel_of_a_rig_is_kept_once_per_calibration_of_the_rig(filled):
    with filled.change() as session:
        session.add_all(
            RigCalibration(
                id=name, state=CalibrationState.READY, rig="left", created_at=NOON, job_id=None
            )
            for name in ("g1", "g2")
        )
    for expected in (3, 0):
        rows = [a_measurement(1) for _ in range(3)]
        rows[1].rig_calibration_id, rows[2].rig_calibration_id = "g1", "g2"
        with filled.change() as session:
            assert add_measurements(session, rows) == expected


def test_a_profile_is_kept_beside_its_measurement_and_once(filled):
    profile = {"d_mm": [0.0, 70.0], "h_mm": [0.0, 0.1]}
    with filled.change() as session:
        with_profile, without = a_measurement(1), a_measurement(2)
        with_profile.wheel = {"frame": 1, "profile": profile}
        without.wheel = {"frame": 2, "profile": None}
        assert add_measurements(session, [with_profile, without]) == 2
    with filled.change() as session:
        again = a_measurement(1)
        again.wheel = {"frame": 1, "profile": {"d_mm": []}}
        assert add_measurements(session, [again]) == 0
    with filled.look() as session:
        first, second = measurements_page(session, limit=10).rows
        assert profiles_of(session, [first, second]) == {first.id: profile}
    assert (first.wheel, second.wheel) == ({"frame": 1}, {"frame": 2})


def test_pages_of_measurements_follow_each_other_without_gap_or_repeat(filled):
    with filled.change() as session:
        add_measurements(session, [a_measurement(frame) for frame in range(7)])
    seen, after = [], 0
    with filled.look() as session:
        while True:
            page = measurements_page(session, limit=3, after=after)
            seen += [row.frame for row in page.rows]
            if not page.more:
                break
            after = page.rows[-1].id
    assert seen == list(range(7))


def test_recordings_come_newest_first_also_where_two_began_together(store):
    with store.change() as session:
        session.add_all([
            a_recording("a", 1),
            a_recording("b", 1),
            a_recording("c", 2),
            a_recording("d", 0),
        ])
    with store.look() as session:
        first = recordings_page(session, limit=2)
        key = (first.rows[-1].opened_at, first.rows[-1].id)
        second = recordings_page(session, limit=2, before=key)
    assert [row.id for row in first.rows] == ["c", "b"]
    assert [row.id for row in second.rows] == ["a", "d"]
    assert (first.more, second.more) == (True, False)


def test_totals_of_frames_add_up_over_recordings(store):
    with store.change() as session:
        session.add_all([
            a_recording("a", recorded=5, lost=1, repeated=0, refused=2),
            a_recording("b", recorded=3, lost=0, repeated=1, refused=0),
            a_recording("still open"),
        ])
    with store.look() as session:
        totals = frame_totals(session)
    fates = {"recorded": 8, "lost": 1, "repeated": 1, "refused": 2}
    assert totals == {("left", fate): count for fate, count in fates.items()}


def test_a_calibration_comes_into_force_only_over_the_version_that_was_seen(filled):
    with filled.change() as session:
        first, second = the(session, Calibration, "c1"), the(session, Calibration, "c2")
        put = {"sensor": "left", "by": Actor("test", "127.0.0.9"), "at": NOON}
        assert activate(session, first, seen=None, **put).version == 1
        with pytest.raises(VersionMissing, match="version 1"):
            activate(session, second, seen=None, **put)
        assert activate(session, second, seen=1, **put).version == 2
        with pytest.raises(VersionConflict, match="version 2, not 1"):
            activate(session, first, seen=1, **put)
        present = active(session, "left")
        assert (present.calibration_id, present.version) == ("c2", 2)
        assert active(session, "right") is None


def test_an_unready_calibration_or_one_of_another_sensor_never_comes_into_force(store):
    with store.change() as session:
        solving = a_calibration("c3", state=CalibrationState.SOLVING)
        session.add(solving)
        put = {"seen": None, "by": Actor("test", "127.0.0.9"), "at": NOON}
        with pytest.raises(StateConflict, match="solving") as refusal:
            activate(session, solving, sensor="left", **put)
        assert refusal.value.state == "solving"
        with pytest.raises(InputUnusable, match="sensor left, not of right"):
            activate(session, a_calibration("c4"), sensor="right", **put)


def test_progress_of_a_cancelled_job_is_not_taken(store):
    with store.change() as session:
        job = add_job(session, "j1", JobKind.CALIBRATE, "c1", at=NOON)
        start(job, at=NOON)
    with store.change() as session:
        assert report_progress(session, "j1", 1.7, "solving")
        assert the(session, Job, "j1").progress == 1.0
        end(the(session, Job, "j1"), JobState.CANCELLED, at=NOON)
    with store.change() as session:
        assert not report_progress(session, "j1", 0.5, "solving")
        assert not report_progress(session, "unknown", 0.5, "solving")


def test_a_job_taken_up_again_keeps_the_moment_it_first_began(store):
    later = NOON + timedelta(hours=1)
    with store.change() as session:
        job = add_job(session, "j1", JobKind.CALIBRATE, "c1", at=NOON)
        start(job, at=NOON)
        start(job, at=later)
        assert job.started_at == NOON
        end(job, JobState.DONE, at=later)
        with pytest.raises(StateConflict, match="is done"):
            start(job, at=later)


def test_a_key_opens_what_its_scopes_say_and_nothing_when_revoked_or_expired(store):
    with store.change() as session:
        assert not any_key(session)
        key = add_key(session, "plc", [Scope.OPERATE], at=NOON)
        assert any_key(session)
        caller = caller_of(session, key, at=NOON)
        assert (caller.may(Scope.OPERATE), caller.may(Scope.READ)) == (True, True)
        assert (caller.may(Scope.CALIBRATE), caller.may(Scope.ADMIN)) == (False, False)
        row = session.query(Key).one()
        row.expires_at = NOON + timedelta(hours=1)
        assert caller_of(session, key, at=NOON) is not None
        assert caller_of(session, key, at=NOON + timedelta(hours=1)) is None
        row.expires_at, row.revoked_at = None, NOON
        assert caller_of(session, key, at=NOON) is None


def test_a_key_is_not_in_the_database(sqlite_store, tmp_path):
    with sqlite_store.change() as session:
        key = add_key(session, "plc", [Scope.READ], at=NOON)
    secret = key.split("_", 2)[2]
    kept = b"".join(path.read_bytes() for path in tmp_path.glob("station.sqlite*"))
    assert b"plc" in kept
    assert secret.encode() not in kept


@pytest.mark.parametrize("text", ["", "tl", "tl_", "tl__", "tl_00000000_x", "x_y_z", "ü_ü_ü"])
def test_what_is_no_key_is_nobodys(store, text):
    with store.change() as session:
        assert caller_of(session, text, at=NOON) is None
