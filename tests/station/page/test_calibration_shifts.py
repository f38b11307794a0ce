"""What a calibration would make of readings, told of a station's store: it is what measuring again
the same pictures has made of them.
"""

from dataclasses import replace

import pytest
from demo_station_truth import INNER, RIGHT
from sqlalchemy import select

from measure import OF_A_PROFILE, ReadingShifts
from station.errors import StateConflict
from station.operations.shifts import shifts_to_tell
from station.pipeline import shifts_with
from station.settings import load_settings
from station.store import Calibration, Measurement, Store


@pytest.fixture(scope="module")
def store(demo_data):
    store = Store.open(f"sqlite:///{demo_data.folder / 'data' / 'station.sqlite'}")
    yield store
    store.close()


@pytest.fixture(scope="module")
def asked(store, demo_data):
    settings = load_settings(demo_data.folder / "station.toml")

    def of(calibration):
        with store.look() as session:
            return shifts_to_tell(session, settings, calibration)

    return of


def measured_again(store, calibration, present):
    """Return by how much the readings of each wheel have come out differently."""
    with store.look() as session:
        rows = session.scalars(select(Measurement).where(Measurement.sensor == RIGHT)).all()
    by = {(row.calibration_id, row.recording_id, row.frame): row.wheel for row in rows}
    return [
        {each: wheel[each]["value"] - before[each]["value"] for each in OF_A_PROFILE}
        for (name, *frame), wheel in by.items()
        if name == calibration and (before := by.get((present, *frame))) is not None
    ]


def test_readings_shift_as_they_did_when_pictures_were_measured_again(store, asked, demo_data):
    name = demo_data.told.calibrations["right-1"]
    to_tell = asked(name)
    found = shifts_with(to_tell.new, to_tell.seen)
    wheels = measured_again(store, name, to_tell.against)
    assert len(wheels) == 4
    for shift in found.shifts:
        true_mm = [wheel[shift.quantity] for wheel in wheels]
        # On another wheel, which is worn otherwise and stood elsewhere: within 1.5 um of them all.
        assert min(true_mm) - 0.0015 < shift.by_mm < max(true_mm) + 0.0015, shift.quantity
        assert 0.0 < shift.u95_mm < 0.03
    told = to_tell.told(found)
    assert told.against == to_tell.against
    assert all(each.reading_u95_mm > each.shift.u95_mm for each in told.shifts)


def test_a_sensor_of_a_rig_is_told_of_on_the_rig(store, demo_data):
    # No sensor of the rig has a second calibration: its first one is moved.
    on_rig = _on_rig(store, demo_data)
    new = next(each for each in on_rig.present if each.sensor == INNER)
    plane = new.plane.model_copy(update={"d": new.plane.d + 0.1})
    found = shifts_with(new.model_copy(update={"plane": plane}), on_rig)
    assert found.reason is None
    assert 0.001 < max(abs(each.by_mm) for each in found.shifts) < 0.1
    same = shifts_with(new, on_rig)
    assert {each.by_mm for each in same.shifts} == {0.0}
    gone = on_rig.profile.model_copy(update={"sensors": ("gone", *on_rig.profile.sensors[1:])})
    foreign = replace(on_rig, profile=gone)
    assert "no longer there" in shifts_with(new, foreign).reason


def _on_rig(store, demo_data):
    """Return the last wheel of the rig, as for a calibration that is not in force."""
    settings = load_settings(demo_data.folder / "station.toml")
    with store.look() as session:
        row = session.get(Calibration, demo_data.told.calibrations[INNER])
        columns = {each.key: getattr(row, each.key) for each in Calibration.__table__.columns}
        session.add(Calibration(**{**columns, "id": "another"}))
        session.flush()
        seen = shifts_to_tell(session, settings, "another").seen
        session.rollback()  # nobody else is to see it
        return seen


def test_what_cannot_be_told_has_its_reason(asked, demo_data):
    assert asked(_present(asked, demo_data)) is None
    to_tell = asked(demo_data.told.calibrations["right-1"])
    unplaced = to_tell.new.model_copy(update={"mounting": None})
    assert "mounting" in shifts_with(unplaced, to_tell.seen).reason
    nowhere = replace(to_tell.seen, reference="no such profile")
    assert "no such profile" in shifts_with(to_tell.new, nowhere).reason
    told = to_tell.told(ReadingShifts((), "it is dark"))
    assert (told.shifts, told.reason) == ((), "it is dark")


def _present(asked, demo_data):
    return asked(demo_data.told.calibrations["right-1"]).against


def test_a_calibration_that_failed_is_not_compared(asked, store):
    with store.look() as session:
        failed = session.scalar(select(Calibration.id).where(Calibration.state == "failed"))
    with pytest.raises(StateConflict, match="only a ready one"):
        asked(failed)
