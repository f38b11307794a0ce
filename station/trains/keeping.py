"""Working out the axles of a pass from its measured wheels, and keeping them in the store."""

from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from itertools import groupby

from sqlalchemy.orm import Session

from measure import Axle, Limits, Placing, SeenWheel, Side, Track, assemble_train
from station.back_to_back import back_to_back_of
from station.documents import StandingDocument
from station.limits import limits_of
from station.settings import SensorSettings, StationSettings, TrackSettings
from station.store import AxleWheel, JsonObject, Measurement, Pass, Recording, recordings_of
from station.store.measured import replace_axles, wheels_of
from station.trains.consist import Consist
from station.trains.jumps import jumps_of
from station.trains.wheels import surest


def keep_axles(session: Session, row: Pass, settings: StationSettings) -> None:
    """Keep a row for each wheel of each axle of a pass, those that nobody saw among them.

    A second time the rows of the first are replaced by the same.
    """
    consist = None if row.consist is None else Consist.from_json(row.consist)
    measured = {wheel.id: wheel for wheel in wheels_of(session, row)}
    # Pictures have no time; beside their numbers, which the same triggers count, a time that only
    # some wheels have would tell nothing.
    timed = all(wheel.wheel.get("time") is not None for wheel in measured.values())
    tracks = _tracks(recordings_of(session, row), list(measured.values()), settings, timed=timed)
    counted = row.axles if row.axles is not None or consist is None else len(consist.wheelsets)
    axles = assemble_train(tracks, counted=counted)
    rows = [
        _row(row, place, axle, side, consist, measured, timed=timed)
        for place, axle in enumerate(axles, start=1)
        for side in Side
    ]
    limits = limits_of(settings.limits)
    distances = _distances(axles, measured, settings.track, limits)
    for each in rows:
        each.jumps = jumps_of(session, row, each, measured, limits)
        each.back_to_back = distances.get(each.place)
    replace_axles(session, row.id, rows)


def _tracks(
    recordings: Sequence[Recording],
    wheels: Sequence[Measurement],
    settings: StationSettings,
    *,
    timed: bool,
) -> list[Track]:
    """Return the track of each sensor, and one of each rig whose sensors were measured together."""
    tracks = []
    for on_rig, members in groupby(sorted(recordings, key=_looker), key=_looker):
        own = list(members)
        sensors = [sensor for each in own if (sensor := settings.sensor(each.sensor)) is not None]
        if not sensors:
            continue  # taken out of the settings since: nothing tells which side it looked at
        names = {each.id for each in own}
        seen = tuple(_seen(wheel, timed=timed) for wheel in wheels if wheel.recording_id in names)
        rig = settings.rig_with(sensors[0].id) if on_rig[0] else None
        silent = None if seen else _why_silent(own)
        name = sensors[0].id if rig is None else rig.id
        triggers = _triggers(own, sensors)
        tracks.append(Track(name, Side(sensors[0].side), seen, triggers, silent))
    return tracks


def _looker(recording: Recording) -> tuple[str, str]:
    """Return what looked: a rig, or a sensor by itself."""
    rig = recording.rig_calibration_id or ""
    return rig, "" if rig else recording.sensor


def _triggers(recordings: Sequence[Recording], sensors: Sequence[SensorSettings]) -> int | None:
    """Return the triggers that were counted; None where they are not the same for all sensors."""
    # The frames of a camera that runs free are numbered by nobody's triggers.
    if any(sensor.trigger == "free" for sensor in sensors):
        return None
    counts = {recording.expected for recording in recordings}
    return counts.pop() if len(counts) == 1 else None


def _seen(row: Measurement, *, timed: bool) -> SeenWheel:
    frames = row.wheel.get("frames") or [row.frame]
    time_s = datetime.fromisoformat(row.wheel["time"]).timestamp() if timed else float(min(frames))
    return SeenWheel(row.id, time_s, first=min(frames), last=max(frames))


def _why_silent(recordings: Sequence[Recording]) -> str:
    if len(recordings) == 1:
        return _why_one_is(recordings[0])
    return "; ".join(f"{each.sensor}: {_why_one_is(each)}" for each in recordings)


def _why_one_is(recording: Recording) -> str:
    if not recording.recorded:
        return "no frame was recorded"
    if recording.calibration_id is None:
        return "no calibration was active"
    return "no wheel of its recording was measured"


def _row(
    row: Pass,
    place: int,
    axle: Axle,
    side: Side,
    consist: Consist | None,
    measured: Mapping[int, Measurement],
    *,
    timed: bool,
) -> AxleWheel:
    wheel = axle.wheel(side)
    keys = [measured[key] for key in wheel.keys]
    best = surest(keys)
    told = consist is not None and axle.placing is not Placing.UNPLACED
    wheelset = consist.at(axle.number, row.axles) if consist is not None and told else None
    return AxleWheel(
        pass_id=row.id,
        place=place,
        side=side,
        number=axle.number,
        placing=axle.placing,
        passed_at=_utc(axle.time_s) if timed else None,
        remark=axle.remark,
        measurement_id=None if best is None else best.id,
        others={"measurements": [each.id for each in keys if each is not best]},
        reason=wheel.reason,
        wheelset=None if wheelset is None else wheelset.wheelset,
        wheelset_side=None if wheelset is None else wheelset.own_side(side),
        vehicle=None if wheelset is None else wheelset.vehicle,
        position=None if wheelset is None else wheelset.position,
        jumps={},
    )


def _distances(
    axles: Sequence[Axle],
    measured: Mapping[int, Measurement],
    track: TrackSettings | None,
    limits: Limits,
) -> dict[int, JsonObject]:
    """Return the back-to-back distance of each axle, by place; none where no track is known."""
    if track is None:
        return {}
    return {
        place: back_to_back_of(
            _standing(axle, Side.LEFT, measured),
            _standing(axle, Side.RIGHT, measured),
            track,
            limits,
        ).model_dump(mode="json")
        for place, axle in enumerate(axles, start=1)
    }


def _standing(
    axle: Axle, side: Side, measured: Mapping[int, Measurement]
) -> list[StandingDocument]:
    kept = (measured[key].wheel.get("standing") for key in axle.wheel(side).keys)
    return [StandingDocument.model_validate(each) for each in kept if each is not None]


def _utc(time_s: float | None) -> datetime | None:
    return None if time_s is None else datetime.fromtimestamp(time_s, UTC)
