"""Shows what the store knows to be wrong with a station, and since when."""

from datetime import timedelta

import pytest
from newest_schema import make_store

from station.operations import DataLayout, utc_now
from station.settings import StationSettings
from station.store import (
    STATION,
    Calibration,
    CalibrationState,
    EndedBy,
    JobKind,
    Pass,
    PassState,
    Recalibration,
    RecalibrationState,
    Recording,
    Store,
    activate,
    add_job,
)
from station.watching import Severity, TroubleKind
from station.watching.store_troubles import store_troubles

SETTINGS = {
    "sensors": [{"id": "inner", "address": "127.0.0.2"}, {"id": "outer", "address": "127.0.0.3"}],
    "rigs": [{"id": "wheel", "sensors": ["inner", "outer"]}],
}
NOW = utc_now()
STARTED = NOW - timedelta(hours=1)


class Watched:
    """A station with a calibration in force on both of its sensors."""

    def __init__(self, root):
        self.settings = StationSettings(data_dir=root, **SETTINGS)
        url = DataLayout(root).store_url
        make_store(url)
        self.store = Store.open(url)
        with self.store.change() as session:
            for sensor in ("inner", "outer"):
                row = Calibration(
                    id=f"of-{sensor}", state=CalibrationState.READY, sensor=sensor,
                    target="dots:7x8:12", method="joint", created_at=STARTED, job_id="j0",
                    recording_ids={"recordings": [], "laser_off": []}, document="{}",
                )  # fmt: skip
                session.add(row)
                session.flush()
                activate(session, row, sensor=sensor, seen=None, by=STATION, at=STARTED)

    def passed(self, name, *, minutes_ago, state=PassState.DONE, **told):
        """Record a pass with the inner sensor."""
        at = NOW - timedelta(minutes=minutes_ago)
        of_pass = {key: told.pop(key) for key in ("ended_by", "ended_why", "reason") if key in told}
        with self.store.change() as session:
            session.add(Pass(id=name, state=state, opened_at=at, finished_at=at, **of_pass))
            session.flush()
            session.add(
                Recording(
                    id=f"pass.{name}.inner", sensor="inner", pass_id=name, path=f"{name}.mcap",
                    opened_at=at, closed_at=at, recorded=4, **told,
                )
            )  # fmt: skip

    def recalibrated(self, state, **told):
        with self.store.change() as session:
            session.add(
                Recalibration(
                    id="r1", state=state, sensor="inner", ordered_at=STARTED, ordered_by="test",
                    job_id="j1", ended_at=NOW, present_id="of-inner", present_version=1,
                    findings={}, version=1, **told,
                )
            )  # fmt: skip

    def troubles(self, *kinds):
        """Return the troubles of these kinds, by kind."""
        with self.store.look() as session:
            found = store_troubles(session, self.settings, NOW, STARTED)
            return {each.kind: each for each in found if not kinds or each.kind in kinds}


@pytest.fixture
def watched(tmp_path):
    watched = Watched(tmp_path)
    yield watched
    watched.store.close()


def test_a_calibrated_station_lacks_the_calibration_of_its_rig_alone(watched):
    (only,) = watched.troubles().values()
    assert (only.kind, only.part) == (TroubleKind.CALIBRATION_MISSING, "rig wheel")
    assert only.severity is Severity.WARNING


def test_frames_lost_are_those_of_the_last_pass(watched):
    watched.passed("p1", minutes_ago=20, lost=2, refused=1, summary="4 of 7")
    found = watched.troubles()[TroubleKind.FRAMES_LOST]
    assert (found.part, found.what) == ("sensor inner", "pass p1: 3 frames lost; 4 of 7")
    assert found.since == NOW - timedelta(minutes=20)
    watched.passed("p2", minutes_ago=10, lost=0, refused=0)
    assert TroubleKind.FRAMES_LOST not in watched.troubles()


def test_a_failed_pass_is_told_with_its_reason(watched):
    watched.passed("p1", minutes_ago=5, state=PassState.FAILED, reason="no frame was recorded")
    assert watched.troubles()[TroubleKind.PASS_FAILED].what == (
        "pass p1 failed: no frame was recorded"
    )


def test_a_controller_that_did_not_end_the_last_pass_is_told(watched):
    watched.passed("p1", minutes_ago=9, ended_by=EndedBy.TIMEOUT, ended_why="quiet for 300 s")
    found = watched.troubles()[TroubleKind.CONTROLLER_SILENT]
    assert (found.part, found.what) == ("controller", "pass p1: quiet for 300 s")
    watched.passed("p2", minutes_ago=3, ended_by=EndedBy.CONTROLLER)
    assert TroubleKind.CONTROLLER_SILENT not in watched.troubles()


def test_a_drift_is_a_warning_and_the_question_about_it_a_notice(watched):
    watched.recalibrated(
        RecalibrationState.ASKING,
        outcome="drifted",
        alarm=True,
        reasons={"reasons": ["the sheet moved"]},
    )
    found = watched.troubles()
    assert found[TroubleKind.CALIBRATION_DOUBTFUL].what == "recalibration r1: the sheet moved"
    assert found[TroubleKind.CALIBRATION_DOUBTFUL].since == NOW
    assert found[TroubleKind.RECALIBRATION_ASKS].severity is Severity.NOTICE


def test_a_recalibration_that_failed_is_told_until_another_is_ordered(watched):
    watched.recalibrated(RecalibrationState.FAILED, reason="given up after 3 h")
    assert "given up" in watched.troubles()[TroubleKind.RECALIBRATION_FAILED].what


def test_a_job_that_waits_for_long_is_told(watched):
    with watched.store.change() as session:
        for name, minutes in (("old", 11), ("new", 1)):
            at = NOW - timedelta(minutes=minutes)
            add_job(session, name, JobKind.MEASURE, "p1", at=at)
        add_job(session, "other", JobKind.COMPACT, "recordings", at=NOW)
    found = watched.troubles()[TroubleKind.JOB_LATE]
    assert found.what == "2 jobs of kind measure wait, the oldest for 11 min"
    assert found.since == NOW - timedelta(minutes=11)
