"""A calibration session that the station takes by itself, of a target mounted before a sensor."""

from calib import Target
from station.errors import StationError
from station.operations import SessionOrder, Sessions, Station, salvage_recording
from station.settings import CaptureSettings
from station.store import STATION, Recalibration, SessionState
from station.worker.context import WorkContext
from station.worker.queue import WorkerQueue
from station.worker.quiet import Quiet


def capture_session(context: WorkContext, row: Recalibration, quiet: Quiet) -> list[str]:
    """Take the session of a recalibration, or what is still missing of it; return why it failed.

    Its name is the recalibration's: a worker that is started anew goes on with it.
    """
    capture = context.settings.recalibration.of(row.sensor).capture
    if capture is None:
        return []
    if row.sensor not in context.captures:
        return ["no pictures were taken: the station does not run, and nobody has the camera"]
    sessions = Sessions(_station(context))
    name = f"recalibration-{row.id}"
    try:
        _take(sessions, name, row.sensor, capture, quiet)
    except StationError as error:
        return [f"no pictures were taken: {error}"]
    return []


def _take(
    sessions: Sessions, name: str, sensor: str, capture: CaptureSettings, quiet: Quiet
) -> None:
    order = SessionOrder(target=Target.parse(capture.target), sensor=sensor)
    view, _ = sessions.open(name, order, by=STATION)
    while view.row.state is SessionState.OPEN and view.row.pictures < capture.pictures:
        # Not `quiet.ensure`: the open session keeps trains off the sensor, so it must go on.
        picture = f"{name}.{view.row.pictures + 1}"
        view = sessions.take_picture(name, name=picture, by=STATION)
        if view.row.pictures < capture.pictures:
            quiet.pause(capture.pause_s)
    if view.row.state is SessionState.OPEN:
        sessions.finish(name, by=STATION)


def _station(context: WorkContext) -> Station:
    return Station(
        settings=context.settings,
        store=context.store,
        layout=context.layout,
        captures=context.captures,
        jobs=WorkerQueue(context.layout.jobs_url),
        salvage=salvage_recording,
        now=context.now,
    )
