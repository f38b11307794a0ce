"""Shows what the metrics and alarms look up, the same on both databases."""

from datetime import timedelta

import pytest
from newest_schema import make_store

from station.operations import utc_now
from station.store import (
    Calibration,
    CalibrationState,
    Job,
    JobKind,
    JobState,
    Measurement,
    Pass,
    PassState,
    Recording,
    Store,
    add_job,
)
from station.store.watched import (
    database_bytes,
    last_measured_pass,
    last_pass_recording,
    last_recalibration,
    measured_since,
    queued_jobs,
    wheels_seen,
)

NOW = utc_now()


def ago(seconds):
    return NOW - timedelta(seconds=seconds)


@pytest.fixture
def store(any_url):
    make_store(any_url)
    store = Store.open(any_url)
    with store.change() as session:
        session.add(
            Calibration(
                id="c1", state=CalibrationState.READY, sensor="left", target="dots:7x8:12",
                method="joint", recording_ids={"recordings": [], "laser_off": []},
                created_at=ago(900), job_id="j0",
            )
        )  # fmt: skip
        for name, seconds in (("p1", 300), ("p2", 100)):
            session.add(
                Job(
                    id=f"m-{name}", kind=JobKind.MEASURE, subject=name, state=JobState.DONE,
                    progress=1.0, doing="done", created_at=ago(seconds), started_at=ago(seconds),
                    ended_at=ago(seconds - 5),
                )
            )  # fmt: skip
            session.add(
                Pass(
                    id=name, state=PassState.DONE, opened_at=ago(seconds + 20),
                    finished_at=ago(seconds), job_id=f"m-{name}",
                )
            )  # fmt: skip
            session.flush()
            session.add(
                Recording(
                    id=f"r-{name}", sensor="left", pass_id=name, path=f"{name}.mcap",
                    opened_at=ago(seconds + 20), closed_at=ago(seconds), calibration_id="c1",
                )
            )  # fmt: skip
            session.flush()
            wheels = [
                {"quality": {"coverage": 0.5}},
                {"quality": {"coverage": 0.75}, "reason": None},
                {"reason": "no stripe"},
            ]
            session.add_all(
                Measurement(
                    recording_id=f"r-{name}", frame=frame, calibration_id="c1", sensor="left",
                    pass_id=name, reference="S1002", software="none", measured_at=NOW, wheel=wheel,
                )
                for frame, wheel in enumerate(wheels)
            )  # fmt: skip
        add_job(session, "q1", JobKind.COMPACT, "recordings", at=ago(60))
        add_job(session, "q2", JobKind.COMPACT, "recordings", at=ago(30))
    yield store
    store.close()


def test_what_is_looked_up_is_of_the_last_pass_and_of_what_waits(store):
    with store.look() as session:
        recording, of_pass = last_pass_recording(session, "left")
        assert (recording.id, of_pass.id) == ("r-p2", "p2")
        assert last_pass_recording(session, "right") is None
        assert last_recalibration(session, "left") is None
        assert queued_jobs(session) == {"compact": (2, ago(60))}
        assert last_measured_pass(session) == "p2"
        (seen,) = wheels_seen(session, "p2").values()
    assert (seen.measured, seen.unmeasurable, seen.coverage) == (2, 1, 0.625)


def test_passes_measured_after_a_moment_are_told_once_with_their_wheels(store):
    with store.look() as session:
        both = measured_since(session, ago(900))
        (later,) = measured_since(session, both[0].ended_at)
        assert measured_since(session, later.ended_at) == []
    assert [each.finished_at for each in both] == [ago(300), ago(100)]
    assert (later.ended_at - later.finished_at, later.wheels) == (timedelta(seconds=5), 3)


def test_a_database_of_postgresql_tells_its_size_and_a_file_has_its_own(store, any_url):
    with store.look() as session:
        size = database_bytes(session)
    assert (size is not None and size > 0) == any_url.startswith("postgresql")
