"""A sensor's calibrations and how it drifts."""

from fastapi import APIRouter, Request, Response

from station.api import PartsOf, Reader, SensorInPath
from station.operations import sensor_at
from station.page.calibration.history import drift_of, history_of
from station.page.shell import ShellOf

router = APIRouter()


@router.get("/calibration/sensors/{sensor_id}")
def get_history(
    sensor_id: SensorInPath, request: Request, parts: PartsOf, shell: ShellOf, _: Reader
) -> Response:
    """Return the page of a sensor."""
    sensor_at(parts.station.settings, sensor_id)
    with parts.station.store.look() as session:
        history = history_of(session, sensor_id)
    return shell.page(
        request,
        "calibration/history.html",
        active="calibration",
        history=history,
        drift=drift_of(history),
    )
