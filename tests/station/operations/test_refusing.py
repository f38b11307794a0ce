"""Refusing a calibration: what may be refused, and that it then never comes into force."""

from datetime import UTC, datetime

import pytest

from station.errors import InputUnusable, NotFound, StateConflict
from station.operations import (
    DataLayout,
    Station,
    refuse_calibration,
    refuse_rig_calibration,
    salvage_recording,
)
from station.settings import StationSettings
from station.store import (
    Actor,
    Calibration,
    CalibrationState,
    RigCalibration,
    Store,
    activate,
    activate_rig,
    migrate,
)
from station.store.lists import audit_page

NOW = datetime(2026, 7, 1, 12, tzinfo=UTC)
BY = Actor("I. Curie", "10.20.0.31")


@pytest.fixture
def station(tmp_path):
    settings = StationSettings(data_dir=tmp_path, sensors=[{"id": "left", "address": "127.45.0.1"}])
    layout = DataLayout.of(settings)
    migrate(layout.store_url)
    store = Store.open(layout.store_url)
    yield Station(
        settings=settings,
        store=store,
        layout=layout,
        captures={},
        jobs=None,
        salvage=salvage_recording,
        now=lambda: NOW,
    )
    store.close()


def keep(station, name, state=CalibrationState.READY):
    common = {"id": name, "state": state, "created_at": NOW, "job_id": "j"}
    with station.store.change() as session:
        session.add(
            Calibration(
                sensor="left",
                target="dots:7x8:12",
                method="joint",
                recording_ids={"recordings": [], "laser_off": []},
                **common,
            )
        )
        session.add(RigCalibration(rig="left", **common))


def bring(station, name):
    with station.store.change() as session:
        row = session.get(Calibration, name)
        activate(session, row, sensor="left", seen=None, by=BY, at=NOW)
        activate_rig(
            session, session.get(RigCalibration, name), rig="left", seen=None, by=BY, at=NOW
        )


BOTH = pytest.mark.parametrize("refuse", [refuse_calibration, refuse_rig_calibration])


@BOTH
def test_a_refusal_is_kept_with_its_reason_and_in_the_audit_trail(station, refuse):
    keep(station, "c1")
    row = refuse(station, "c1", why="  the board had slipped ", by=BY)
    assert (row.refused_by, row.refused_why) == (BY.name, "the board had slipped")
    assert row.refused_at == NOW
    with station.store.look() as session:
        (entry,) = audit_page(session, limit=9).rows
    assert (entry.action, entry.subject) == ("refuse", "c1")
    assert entry.after == {"why": "the board had slipped"}


@BOTH
def test_the_same_refusal_again_changes_nothing_and_another_is_refused(station, refuse):
    keep(station, "c1")
    refuse(station, "c1", why="slipped", by=BY)
    refuse(station, "c1", why="slipped", by=BY)
    with pytest.raises(StateConflict, match=r"was refused by I\. Curie \(slipped\)"):
        refuse(station, "c1", why="another reason", by=BY)
    with station.store.look() as session:
        assert len(audit_page(session, limit=9).rows) == 1


@BOTH
def test_a_refused_calibration_does_not_come_into_force(station, refuse):
    keep(station, "c1")
    refuse(station, "c1", why="slipped", by=BY)
    with pytest.raises(StateConflict, match="calibrate again"):
        bring(station, "c1")


@BOTH
def test_what_is_in_force_or_not_ready_is_not_refused(station, refuse):
    keep(station, "c1")
    bring(station, "c1")
    with pytest.raises(StateConflict, match="in force"):
        refuse(station, "c1", why="old", by=BY)
    keep(station, "c2", CalibrationState.SOLVING)
    with pytest.raises(StateConflict, match="only a ready one"):
        refuse(station, "c2", why="slow", by=BY)
    with pytest.raises(NotFound):
        refuse(station, "c3", why="none", by=BY)


@BOTH
@pytest.mark.parametrize("why", ["", "  ", "x" * 501])
def test_a_reason_is_needed_and_not_a_book(station, refuse, why):
    keep(station, "c1")
    with pytest.raises(InputUnusable, match="1 to 500"):
        refuse(station, "c1", why=why, by=BY)
