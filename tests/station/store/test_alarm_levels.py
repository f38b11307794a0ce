"""Shows that what wheels raise is taken out of their rows alike on SQLite and on PostgreSQL, and
that passes are found by a piece of their name."""

from datetime import UTC, datetime, timedelta

import pytest

from measure import Placing, Side
from station.store import (
    AxleWheel,
    Calibration,
    CalibrationState,
    Measurement,
    Pass,
    PassState,
    Recording,
)
from station.store.lists import passes_page
from station.store.measured import wheel_levels
from station.trains import AlarmTally, alarm_tallies

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)
JUMP = {"change": 1.5, "u95": 0.1, "limit": 1.0, "before": "p0"}


@pytest.fixture
def filled(store):
    """A store with three passes."""
    calibration = Calibration(
        id="c1",
        state=CalibrationState.READY,
        sensor="left",
        target="dots:7x8:12",
        method="joint",
        recording_ids={"recordings": [], "laser_off": []},
        created_at=NOON,
        job_id="j",
    )
    with store.change() as session:
        session.add(calibration)
        for day, (name, train) in enumerate([("p1", "RB 17"), ("p2", None), ("100%_x", "rb 99")]):
            at = NOON + timedelta(days=day)
            session.add(Pass(id=name, state=PassState.DONE, opened_at=at, train=train))
    return store


def a_wheel(session, frame, **wheel):
    """Add a measured wheel and return its id."""
    if session.get(Recording, "p1") is None:
        opened = {"path": "x", "opened_at": NOON, "recovered": False}
        session.add(Recording(id="p1", sensor="left", pass_id="p1", **opened))
        session.flush()
    row = Measurement(
        recording_id="p1",
        frame=frame,
        calibration_id="c1",
        sensor="left",
        pass_id="p1",
        reference="S1002",
        software="treadline 0",
        measured_at=NOON,
        wheel={"reason": None, **wheel},
    )
    session.add(row)
    session.flush()
    return row.id


def an_axle(session, place, left, right, *, jumps=None, between=None):
    for side, measurement in ((Side.LEFT, left), (Side.RIGHT, right)):
        session.add(
            AxleWheel(
                pass_id="p1",
                place=place,
                side=side,
                placing=Placing.CERTAIN,
                measurement_id=measurement,
                others={"measurements": []},
                jumps=(jumps or {}) if side is Side.LEFT else {},
                back_to_back=between,
            )
        )


def reading(alarm):
    return {"value": 1.0, "u95": 0.1, "status": "ok", "alarm": alarm}


def test_levels_jumps_and_distances_are_counted_once_each(filled):
    with filled.change() as session:
        worn = a_wheel(session, 1, tread_wear=reading("alarm"), flange_height=reading("warning"))
        fine = a_wheel(session, 2, tread_wear=reading("none"))
        dark = a_wheel(session, 3, reason="no stripe", tread_wear=reading("unknown"))
        between = {"value": 1364.0, "u95": 0.2, "alarm": "alarm"}
        an_axle(session, 1, worn, fine, jumps={"tread_wear": JUMP}, between=between)
        an_axle(session, 2, dark, None)
    with filled.look() as session:
        # Of tread wear, its jump, and the distance that both wheels of the axle hold.
        tally = AlarmTally(alarms=3, warnings=1, wheels=4, measured=2)
        assert alarm_tallies(session, ["p1", "p2"]) == {"p1": tally}
        levels = {(each.side, *each.levels) for each in wheel_levels(session, ["p1"])}
    assert (Side.LEFT, "warning", "alarm") in levels
    assert (Side.RIGHT,) in levels


def test_passes_are_found_by_a_piece_of_their_name(filled):
    found = {
        "P": ["p2", "p1"],
        "%_": ["100%_x"],
        "_p": [],
    }
    with filled.look() as session:
        for piece, names in found.items():
            rows = passes_page(session, limit=9, id_holds=piece).rows
            assert [row.id for row in rows] == names, piece
        named = passes_page(session, limit=9, train_holds="rb").rows
        assert [row.id for row in named] == ["100%_x", "p1"]
        both = passes_page(session, limit=9, train_holds="17", id_holds="p").rows
        assert [row.id for row in both] == ["p1"]
