"""Shows that recordings are found by what a person remembers of them, on either database, and what
was measured from one."""

from datetime import UTC, datetime, timedelta

import pytest

from station.store import (
    Calibration,
    Job,
    JobKind,
    JobState,
    Measurement,
    Pass,
    PassState,
    Recording,
    Replay,
    RigCalibration,
)
from station.store.lists import Span
from station.store.recordings_found import (
    RecordingKind,
    RecordingSearch,
    measured_from,
    measured_together_with,
    recordings_found,
    replays_of,
)

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)
ROWS = {
    "pass.rb17.left": {"pass_id": "rb17", "recorded": 8, "lost": 0, "complete": True},
    "pass.rb17.right": {"pass_id": "rb17", "recorded": 7, "lost": 1, "sensor": "right"},
    "refused": {"recorded": 7, "lost": 0, "refused": 1},
    "cut": {"recorded": 3, "recovered": True, "complete": False},
    "upload.1": {"recorded": 5, "sha256": "00", "deleted_at": NOON},
    "running": {"closed_at": None},
    "100%_sure": {"recorded": 1},
}


@pytest.fixture
def filled(store):
    with store.change() as session:
        session.add(Pass(id="rb17", state=PassState.DONE, opened_at=NOON))
        session.flush()
        for place, (name, values) in enumerate(ROWS.items()):
            opened = NOON - timedelta(hours=place)
            given = {"sensor": "left", "path": "x", "closed_at": NOON, "recovered": False} | values
            session.add(Recording(id=name, opened_at=opened, **given))
    return store


def names(store, **search):
    with store.look() as session:
        page = recordings_found(session, RecordingSearch(**search), limit=10)
        return [row.id for row in page.rows]


@pytest.mark.parametrize(
    ("search", "expected"),
    [
        ({}, list(ROWS)),
        ({"name_holds": "RB17"}, ["pass.rb17.left", "pass.rb17.right"]),
        ({"name_holds": "RB17", "sensor": "right"}, ["pass.rb17.right"]),
        ({"name_holds": "%_"}, ["100%_sure"]),
        ({"kind": RecordingKind.LOSSY}, ["pass.rb17.right", "refused", "cut"]),
        ({"kind": RecordingKind.CUT_SHORT}, ["cut"]),
        ({"kind": RecordingKind.UPLOADED}, ["upload.1"]),
        ({"kind": RecordingKind.DELETED}, ["upload.1"]),
        ({"kind": RecordingKind.RUNNING}, ["running"]),
        ({"span": Span(NOON - timedelta(hours=1), NOON)}, ["pass.rb17.right"]),
        ({"sensor": "nobody"}, []),
    ],
)
def test_recordings_are_found_by_what_is_given_the_newest_first(filled, search, expected):
    assert names(filled, **search) == expected


def test_pages_of_two_hold_every_recording_once(filled):
    found, before = [], None
    with filled.look() as session:
        more = True
        while more:
            page = recordings_found(session, RecordingSearch(), limit=2, before=before)
            found += [row.id for row in page.rows]
            before, more = (page.rows[-1].opened_at, page.rows[-1].id), page.more
    assert found == list(ROWS)


def measured(session, recording_id, frame, *, rig=None, sensors=()):
    row = Measurement(
        recording_id=recording_id,
        frame=frame,
        calibration_id="c1",
        rig_calibration_id=rig,
        sensor="rig" if rig else "left",
        pass_id="rb17",
        reference="S1002",
        software="test",
        measured_at=NOON,
        wheel={"sensors": list(sensors)},
    )
    session.add(row)
    session.flush()


def test_wheels_of_a_rig_are_found_from_each_of_its_recordings(filled):
    with filled.change() as session:
        session.add(
            Calibration(
                id="c1",
                state="ready",
                sensor="left",
                target="t",
                method="joint",
                recording_ids={},
                created_at=NOON,
                job_id="j",
            )
        )
        for name in ("g1", "g2"):
            session.add(RigCalibration(id=name, state="ready", rig="rig", created_at=NOON))
        session.flush()
        for side in ("left", "right"):
            row = session.get_one(Recording, f"pass.rb17.{side}")
            row.calibration_id, row.rig_calibration_id = "c1", "g1"
        measured(session, "pass.rb17.left", 4, rig="g1", sensors=["left", "right"])
        measured(session, "pass.rb17.left", 9, rig="g1", sensors=["left"])
        measured(session, "pass.rb17.left", 2)
        # Measured once more by another calibration, by which another frame shows the wheel best.
        measured(session, "pass.rb17.left", 5, rig="g2", sensors=["left", "right"])
    with filled.look() as session:
        left, right = (
            session.get_one(Recording, f"pass.rb17.{each}") for each in ("left", "right")
        )
        assert [row.frame for row in measured_from(session, left.id)] == [4, 9, 2, 5]
        assert [row.frame for row in measured_together_with(session, right)] == [4]
        assert measured_together_with(session, left) == []
        assert measured_together_with(session, session.get_one(Recording, "cut")) == []


def test_replays_of_a_recording_are_found_before_they_came_to_anything(filled):
    with filled.change() as session:
        for number, steps in enumerate([[["cut"], ["refused"]], [["refused"]], [["cut"]]]):
            at = NOON + timedelta(minutes=number)
            kept = {"kind": JobKind.REPLAY, "state": JobState.QUEUED, "progress": 0.0, "doing": ""}
            session.add(Job(id=f"j{number}", subject=f"v{number}", created_at=at, **kept))
            session.add(
                Replay(
                    id=f"v{number}",
                    ordered_at=at,
                    ordered_by="somebody",
                    job_id=f"j{number}",
                    steps={"steps": steps},
                    calibrations={},
                    reference="S1002",
                    results={},
                )
            )
    with filled.look() as session:
        assert [row.id for row in replays_of(session, "cut")] == ["v2", "v0"]
        assert replays_of(session, "running") == []
