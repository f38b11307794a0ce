"""What happened at the demo station in the six weeks before now."""

from dataclasses import dataclass
from datetime import datetime, timedelta

from demo_station_desk import Desk, days_before, shots_of
from demo_station_truth import INNER, OUTER, RIGHT

from calib import Picture
from station.operations import (
    Keys,
    ReplayOrder,
    Uploads,
    answer_recalibration,
    cancel_job,
    order_replay,
)
from station.operations.inspection import Inspected
from station.recalibration import Schedule
from station.recording.inspecting import inspect
from station.store import Actor, JobKind, Recalibration, RecalibrationState
from station.store.callers import Scope
from station.trains import Consist, Wheelset
from station.worker.scheduling import order_what_is_owed

METROLOGIST = Actor("I. Curie", "10.20.0.31")
SECOND = Actor("metrology 2", "10.20.0.32")
OPERATOR = Actor("operator", "10.20.0.12")
ADMINISTRATOR = Actor("administrator", "10.20.0.2")
MARKUP = "Müller & <b>Söhne</b>"
SCRIPT = '<script>alert("x")</script>'
TRAIN = "RB 17"
VEHICLE = "DBpza 752"
PASSES = tuple(f"rb17-{week}" for week in range(1, 7))
LOST_FRAME, DARK_WHEEL, UNSEEN_TRAIN = PASSES[2], "freight-88", "shunting-3"


@dataclass(frozen=True)
class Told:
    """What of the story tests name."""

    calibrations: dict[str, str]
    """By what they are of, as ``right-1``."""
    upload: str
    replay: str
    keys: dict[str, str]
    """The text of a key of each scope."""


def tell(desk: Desk, end: datetime) -> Told:
    """Let it all happen; the clock then stands at the end."""
    keys, calibrations = _keys(desk), _calibrate_all(desk)

    def at(days: float) -> Desk:
        desk.clock.set(days_before(end, days))
        return desk

    _weekly(at(35.1), 0)
    calibrations["right-2"] = _second_calibration(at(30.0))
    _weekly(at(28.1), 1)
    _weekly(at(21.1), 2)
    _failed_calibration(at(20.0))
    _weekly(at(14.1), 3)
    _night(at(13.6), "right-night-1", 1)
    upload = _guests(at(9.0))
    _weekly(at(7.1), 4)
    _night(at(6.0), "right-night-2", 2)
    _refuse(desk)
    replay = _replay(at(4.0), calibrations)
    # By the last night there was, whatever the time of day of the end: it leaves what Now shows.
    evening = _schedule(desk).last_due(end) - timedelta(hours=14)
    _catch_up(desk, evening)
    desk.clock.set(evening)
    desk.session("right-night-3", {RIGHT: desk.pictures.nights[3]}, by=OPERATOR)
    _catch_up(desk, days_before(end, 0.1))
    _weekly(at(0.1), 5)
    _catch_up(desk, end)
    at(0.0)
    return Told(calibrations, upload, replay, keys)


def _keys(desk: Desk) -> dict[str, str]:
    def desk_of_keys() -> Keys:
        return Keys(desk.store, ADMINISTRATOR, desk.clock())

    keys = {scope.value: desk_of_keys().create(f"demo {scope}", [scope], None) for scope in Scope}
    desk.clock.wait(minutes=3)
    lent = desk_of_keys().create("visitor", [Scope.READ], desk.clock() + timedelta(days=7))
    lost = desk_of_keys().create("tablet 1", [Scope.OPERATE], None)
    desk.clock.wait(days=1)
    desk_of_keys().revoke(lost.split("_")[1])
    assert lent != lost
    return keys


def _calibrate_all(desk: Desk) -> dict[str, str]:
    targets = desk.pictures.targets
    desk.session("rig-first", {name: targets[name] for name in (INNER, OUTER)}, by=METROLOGIST)
    calibrations = {}
    for sensor in (INNER, OUTER):
        name = desk.calibrate(sensor, "rig-first", by=METROLOGIST)
        desk.activate(sensor, name, by=METROLOGIST)
        calibrations[sensor] = name
    calibrations["rig"] = desk.calibrate_rig("rig-first", by=METROLOGIST)
    desk.activate_rig(calibrations["rig"], by=METROLOGIST)
    desk.session("right-first", {RIGHT: targets[RIGHT]}, by=METROLOGIST)
    calibrations["right-1"] = desk.calibrate(RIGHT, "right-first", by=METROLOGIST)
    desk.activate(RIGHT, calibrations["right-1"], by=METROLOGIST)
    # By the old method too, to see what it leaves out; nobody brought that into force.
    calibrations["right-preplanar"] = desk.calibrate(
        RIGHT, "right-first", by=SECOND, method="preplanar"
    )
    return calibrations


def _weekly(desk: Desk, week: int) -> None:
    """Have the train pass that comes every week, its wheels worn a little more each time."""
    pass_id = PASSES[week]
    shots = 2 if pass_id == LOST_FRAME else 1
    axles = [shots_of(desk.pictures, place + week, shots) for place in range(4)]
    if pass_id == LOST_FRAME:
        axles[1][0][OUTER] = None
        axles[3][1][RIGHT] = None
    name = MARKUP if week == 3 else TRAIN
    desk.train(pass_id, axles, name=name, consist=_consist())


def _consist() -> Consist:
    vehicles = (VEHICLE, VEHICLE, MARKUP, MARKUP)
    return Consist(
        tuple(
            Wheelset(f"WS-{1041 + place}", vehicle, f"{1 + place % 2}")
            for place, vehicle in enumerate(vehicles)
        )
    )


def _second_calibration(desk: Desk) -> str:
    desk.session("right-second", {RIGHT: desk.pictures.nights[0]}, by=SECOND)
    name = desk.calibrate(RIGHT, "right-second", by=SECOND)
    desk.activate(RIGHT, name, by=SECOND)
    return name


def _failed_calibration(desk: Desk) -> None:
    """Calibrate from two pictures, which are too few."""
    desk.session("right-too-few", {RIGHT: desk.pictures.nights[0][:2]}, by=SECOND)
    desk.calibrate(RIGHT, "right-too-few", by=SECOND)


def _guests(desk: Desk) -> str:
    """Let other trains come: one longer with a wheel nobody can measure, one nobody saw."""
    pictures = desk.pictures
    axles = [shots_of(pictures, level) for level in range(6)]
    for shot in axles[2]:
        shot[RIGHT] = pictures.dark
    desk.train(DARK_WHEEL, axles, name=SCRIPT)
    desk.clock.wait(hours=1)
    nothing: dict[str, Picture | None] = dict.fromkeys(desk.films)
    desk.train(UNSEEN_TRAIN, [[nothing]] * 4, name="shunting")
    desk.clock.wait(hours=1)
    return _upload(desk)


def _upload(desk: Desk) -> str:
    """Take in a recording that was made elsewhere: here, of a pass whose row is another's."""
    uploads = Uploads(desk.station, inspect=lambda path: Inspected(**inspect(path)))
    source = desk.station.layout.root / desk.station.layout.pass_recording(PASSES[0], RIGHT)
    body = source.read_bytes()
    upload = uploads.begin(len(body))
    upload.take(body)
    row, _ = uploads.finish(upload, OPERATOR)
    return row.id


def _night(desk: Desk, session: str, draw: int) -> None:
    """Show the right sensor its target; have all recalibrated in the night that follows."""
    desk.session(session, {RIGHT: desk.pictures.nights[draw]}, by=OPERATOR)
    schedule = _schedule(desk)
    desk.clock.set(schedule.next_due(desk.clock()) + timedelta(seconds=1))
    _recalibrate(desk)


def _catch_up(desk: Desk, until: datetime) -> None:
    """Have what the schedule owes by a moment done when it was due."""
    due = _schedule(desk).last_due(until) + timedelta(seconds=1)
    desk.clock.set(max(due, desk.clock()))
    _recalibrate(desk)


def _schedule(desk: Desk) -> Schedule:
    schedule = Schedule.from_settings(desk.settings.recalibration)
    assert schedule is not None
    return schedule


def _recalibrate(desk: Desk) -> None:
    for row in order_what_is_owed(desk.worker.context):
        desk.worker.submit(JobKind.RECALIBRATE, row.job_id)


def _refuse(desk: Desk) -> None:
    """Have a person refuse what the last night asked."""
    desk.clock.wait(hours=5)
    with desk.store.look() as session:
        asking = [
            row for row in session.query(Recalibration) if row.state is RecalibrationState.ASKING
        ]
    for row in asking:
        why = f"the board had slipped in its holder, see the note of {MARKUP} {SCRIPT}"
        answer_recalibration(
            desk.station, row.id, bring=False, why=why, seen=row.version, by=METROLOGIST
        )


def _replay(desk: Desk, calibrations: dict[str, str]) -> str:
    """Have what the right sensor recorded measured with its first calibration; cancel another."""
    order = ReplayOrder((f"pass.{PASSES[4]}.{RIGHT}",), None, {RIGHT: calibrations["right-1"]})
    done = order_replay(desk.station, order, by=METROLOGIST).row
    desk.worker.resting = True
    view = order_replay(desk.station, order, by=OPERATOR)
    desk.clock.wait(minutes=1)
    cancel_job(desk.station, view.job.id, by=OPERATOR)
    desk.worker.resting = False
    return done.id
