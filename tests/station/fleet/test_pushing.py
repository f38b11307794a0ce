"""Shows that what a station knows comes to the fleet once, whatever is cut off meanwhile.

The stations' stores are filled by hand; that the triggers follow the real writers is shown by the
store's own tests and by the station's tests that measure.
"""

import shutil
import threading
from datetime import timedelta
from pathlib import Path

import pytest
from fleet_stations import BEGAN, CutOff, Sending, calibration, counts
from newest_schema import make_store
from sqlalchemy import make_url, select

from measure import Alarm
from station.errors import StoreUnusable
from station.fleet import Fleet, migrate_fleet
from station.fleet.tables import (
    FleetAlarm,
    FleetAxle,
    FleetCalibration,
    FleetEpoch,
    FleetPass,
    FleetRefusal,
    FleetStation,
    FleetWheel,
)
from station.store import (
    Actor,
    AxleWheel,
    Measurement,
    Pass,
    PassState,
    Store,
    activate,
    sqlite_url,
)
from station.store.changes import changes_after, store_epoch
from station.store.measured import axles_of, replace_axles


def rows(fleet, table, **where):
    with fleet.look() as session:
        return session.scalars(select(table).filter_by(**where)).all()


def test_what_is_new_comes_once_and_nothing_is_left(fleet, station):
    north = station()
    for number in range(3):
        north.train(number)
    pushed = north.push()
    assert (pushed.changes, pushed.left.count) == (3, 0)
    with north.store.look() as session:
        assert pushed.number == changes_after(session, 0, limit=10)[-1].number
    assert counts(fleet) == (3, 6, 6)
    again = north.push()
    assert again.changes == 0
    assert counts(fleet) == (3, 6, 6)


def test_many_batches_come_in_the_order_of_writing(fleet, station):
    north = station(changes_in_batch=2)
    for number in reversed(range(7)):
        north.train(number)
    cut = CutOff(fleet, 3, committed=False)  # two greetings and a batch
    with pytest.raises(StoreUnusable):
        north.push(cut)
    assert sorted(row.id for row in rows(fleet, FleetPass)) == ["p00005", "p00006"]
    assert rows(fleet, FleetStation)[0].unsent == 5


@pytest.mark.parametrize("committed", [False, True])
def test_a_batch_cut_off_at_any_moment_is_there_once(fleet, station, committed):
    north = station(changes_in_batch=2)
    for number in range(14):
        north.train(number, axles=1)
    for good in range(5):
        with pytest.raises(StoreUnusable):
            north.push(CutOff(fleet, good, committed=committed))
        passes, wheels, axles = counts(fleet)
        assert passes == wheels == axles
    north.push()
    assert counts(fleet) == (14, 14, 14)
    assert len(rows(fleet, FleetEpoch)) == 1


def test_what_is_corrected_later_is_sent_again(fleet, station):
    north = station()
    name = north.train(1)
    north.train(2)
    north.push()
    with north.store.change() as session:
        session.get(Pass, name).state = PassState.RECOVERED
        axles = axles_of(session, name)
        for axle in axles:
            session.expunge(axle)
        told = [
            AxleWheel(
                pass_id=name,
                place=axle.place,
                side=axle.side,
                placing=axle.placing,
                number=axle.number,
                measurement_id=axle.measurement_id,
                others=axle.others,
                wheelset="told-later",
                wheelset_side=axle.side,
                jumps={},
            )
            for axle in axles
        ]
        replace_axles(session, name, told)
    pushed = north.push()
    assert pushed.changes == 1
    assert {row.wheelset for row in rows(fleet, FleetAxle, pass_id=name)} == {"told-later"}
    assert rows(fleet, FleetPass, id=name)[0].state == "recovered"
    assert counts(fleet) == (2, 4, 4)


def test_two_stations_with_the_same_keys_stand_side_by_side(fleet, station):
    north, south = station("north", changes_in_batch=1), station("south", changes_in_batch=1)
    for number in range(4):
        north.train(number, value=30.0)
        south.train(number, value=31.0)
    threads = [threading.Thread(target=each.push) for each in (north, south)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(30.0)
    assert counts(fleet, "north") == counts(fleet, "south") == (4, 8, 8)
    values = {
        name: {
            row.readings["flange_height"]["value"] for row in rows(fleet, FleetWheel, station=name)
        }
        for name in ("north", "south")
    }
    assert values == {"north": {30.0}, "south": {31.0}}


def test_a_clock_that_is_wrong_loses_nothing_and_shows(fleet, station):
    ahead, behind = station("ahead", ahead=timedelta(hours=2)), station("behind")
    behind.ahead = timedelta(hours=-2)
    for each in (ahead, behind):
        each.train(1)
        each.push()
        each.ahead -= timedelta(hours=1)  # set while it runs: order is by number, not by time
        each.train(0)
        each.push()
    assert counts(fleet) == (4, 8, 8)
    clocks = {row.id: row.clock_ahead_s for row in rows(fleet, FleetStation)}
    # The round itself takes less than a minute, of 3600 s.
    assert clocks["ahead"] == pytest.approx(3600.0, abs=60.0)
    assert clocks["behind"] == pytest.approx(-3 * 3600.0, abs=60.0)


def restored(station, tmp_path, copy):
    station.store.close()
    path = tmp_path / "restored.sqlite"
    shutil.copy(copy, path)
    return Sending(Store.open(sqlite_url(path)), station.fleet, station.name)


def backup(station, tmp_path):
    path = tmp_path / "backup.sqlite"
    with station.store.change() as session:
        source = make_url(str(session.get_bind().url)).database
    station.store.close()  # folds the log into the file
    shutil.copy(Path(source), path)
    station.store = Store.open(sqlite_url(Path(source)))
    return path


def test_a_store_brought_back_overwrites_nothing_of_what_it_forgot(fleet, station, tmp_path):
    north = station()
    north.train(0, value=30.0)
    north.push()
    copy = backup(north, tmp_path)
    north.train(1, value=31.0)
    north.push()
    north = restored(north, tmp_path, copy)
    later = BEGAN + timedelta(days=9)
    north.train(1, value=41.0, at=later)  # another train, under keys that were given away before
    north.push()
    north.push()
    passes = {(row.epoch, row.id): row for row in rows(fleet, FleetPass)}
    assert sorted(passes) == [(1, "p00000"), (1, "p00001"), (2, "p00000"), (2, "p00001")]
    # The one that both tell of counts once; the others are two trains.
    assert [key for key, row in passes.items() if row.superseded] == [(1, "p00000")]
    assert counts(fleet) == (3, 6, 6)
    values = [row.readings["flange_height"]["value"] for row in rows(fleet, FleetWheel)]
    assert sorted(set(values)) == [30.0, 31.0, 41.0]
    north.store.close()


def test_a_backup_brought_back_before_anything_was_lost_goes_on_as_before(fleet, station, tmp_path):
    north = station()
    north.train(0)
    north.push()
    north = restored(north, tmp_path, backup(north, tmp_path))
    north.train(1)
    north.push()
    assert len(rows(fleet, FleetEpoch)) == 1
    assert counts(fleet) == (2, 4, 4)
    north.store.close()


def test_a_fleet_brought_back_from_a_backup_is_sent_what_it_forgot(fleet, station):
    north = station(changes_in_batch=1)
    for number in range(3):
        north.train(number)
    with pytest.raises(StoreUnusable):
        north.push(CutOff(fleet, 3, committed=False))
    mark = rows(fleet, FleetEpoch)[0]
    north.push()
    with fleet.change() as session:
        for table in (FleetAxle, FleetWheel):
            for row in session.scalars(select(table).where(table.pass_id != "p00000")):
                session.delete(row)
        session.flush()
        for row in session.scalars(select(FleetPass).where(FleetPass.id != "p00000")):
            session.delete(row)
        epoch = session.scalars(select(FleetEpoch)).one()
        epoch.number, epoch.token = mark.number, mark.token
    north.push()
    assert len(rows(fleet, FleetEpoch)) == 1
    assert counts(fleet) == (3, 6, 6)


def test_nothing_is_sent_while_a_train_passes(fleet, station):
    north = station()
    north.train(0)
    with north.store.change() as session:
        session.add(Pass(id="now", state=PassState.RECORDING, opened_at=BEGAN))
    pushed = north.push()
    assert (pushed.changes, pushed.left.count) == (0, 2)
    with north.store.change() as session:
        session.get(Pass, "now").state = PassState.DONE
    assert north.push().changes == 2


def test_a_change_that_is_not_taken_is_named_and_holds_up_no_other(fleet, station):
    north = station()
    for number in range(3):
        north.train(number)
    with north.store.change() as session:
        session.get(Pass, "p00001").reason = "unreadable"
        # The key of its measurement is taken by another pass, as by a defect of a store.
        row = session.scalars(select(Measurement).where(Measurement.pass_id == "p00001")).first()
    _take_key(fleet, north, row.id)
    assert north.push().changes
    refused = rows(fleet, FleetRefusal)
    assert [(each.kind, each.key) for each in refused] == [("pass", "p00001")]
    assert {each.id for each in rows(fleet, FleetPass)} == {"p00000", "p00002", "other"}
    with fleet.change() as session:
        for wheel in session.scalars(select(FleetWheel).where(FleetWheel.pass_id == "other")):
            session.delete(wheel)
    with north.store.change() as session:
        session.get(Pass, "p00001").reason = None
    north.push()
    assert rows(fleet, FleetRefusal) == []
    assert len(rows(fleet, FleetPass)) == 4


def _take_key(fleet, north, wheel_id):
    empty = Sending(north.store, fleet, north.name, changes_in_batch=1)
    with pytest.raises(StoreUnusable):
        empty.push(CutOff(fleet, 2, committed=False))
    own = {"station": north.name, "epoch": 1}
    wheel = FleetWheel(
        **own,
        id=wheel_id,
        pass_id="other",
        recording_id="r",
        frame=0,
        sensor="left",
        calibration_id="c",
        reference="S1002",
        software="-",
        measured_at=BEGAN,
        readings={},
    )
    with fleet.change() as session:
        session.add(FleetPass(**own, id="other", opened_at=BEGAN, state="done", superseded=False))
        session.flush()
        session.add(wheel)


def test_calibrations_and_alarms_come_with_their_figures(fleet, station):
    north = station()
    north.train(0, axles=1, alarm=Alarm.ALARM)
    with north.store.change() as session:
        other = calibration("d")
        session.add(other)
        session.flush()
        activate(session, other, sensor="left", seen=None, by=Actor("somebody"), at=BEGAN)
    north.push()
    (found,) = rows(fleet, FleetCalibration)
    assert (found.of, found.name, found.version) == ("sensor", "left", 1)
    assert (found.rms_dots_px, found.rms_stripe_px, found.passed) == (0.11, 0.22, True)
    (alarm,) = rows(fleet, FleetAlarm)
    assert (alarm.quantity, alarm.alarm, alarm.wheelset) == ("flange_height", "alarm", "ws-0")


def test_two_that_send_for_one_store_do_not_send_twice(fleet, station):
    north = station(changes_in_batch=1)
    for number in range(8):
        north.train(number)
    troubles = []

    def send():
        try:
            north.push()
        except Exception as error:  # noqa: BLE001  what it was is judged below
            troubles.append(type(error).__name__)

    threads = [threading.Thread(target=send) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(30.0)
    north.push()
    assert set(troubles) <= {"MarkMoved"}
    assert counts(fleet) == (8, 16, 16)
    with north.store.look() as session:
        assert rows(fleet, FleetEpoch)[0].store_epoch == store_epoch(session)


def test_a_value_that_postgresql_does_not_take_is_refused_alone(postgres, tmp_path):
    url = postgres.empty_database()
    migrate_fleet(url)
    fleet = Fleet.open(url)
    make_store(sqlite_url(tmp_path / "north.sqlite"))
    north = Sending(Store.open(sqlite_url(tmp_path / "north.sqlite")), fleet, "north")
    north.train(0)
    north.train(1, value=float("nan"))  # JSON has none, SQLite takes it
    north.train(2)
    north.push()
    assert {row.id for row in rows(fleet, FleetPass)} == {"p00000", "p00002"}
    (refused,) = rows(fleet, FleetRefusal)
    assert (refused.key, "NaN" in refused.why) == ("p00001", True)
    north.store.close()
    fleet.close()
