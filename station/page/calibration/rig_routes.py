"""The report of a rig's calibration: what each of its sensors saw, and where that belongs."""

from typing import Annotated

from fastapi import APIRouter, Path, Request, Response
from fastapi.responses import JSONResponse

from station.api import IdInPath, PartsOf, Reader, SensorInPath, for_a_moment, from_the_store
from station.documents import RigDocument
from station.errors import NotFound
from station.operations import rig_calibration_points, rig_pictures_of
from station.page.calibration.pictures import picture_of, pictures_drawn
from station.page.calibration.report import rig_report_of
from station.page.calibration.rig_pictures import SolvedOnRig, sensors_with_points
from station.page.calibration.solving import solving_answer
from station.page.shell import ShellOf
from station.report import evidence_of
from station.store import RigCalibration, Store, the

router = APIRouter(prefix="/rig-calibrations/{calibration_id}")
_SENSOR = "/sensors/{sensor_id}"


@router.get("")
def get_report(
    calibration_id: IdInPath, request: Request, parts: PartsOf, shell: ShellOf, _: Reader
) -> Response:
    """Return the report of a rig's calibration."""
    with parts.station.store.look() as session:
        report = rig_report_of(session, calibration_id)
        seeing = sensors_with_points(session, calibration_id)
    return shell.page(
        request, "calibration/report.html", active="calibration", report=report, seeing=seeing
    )


@router.get("/solving")
@for_a_moment
def get_solving(
    calibration_id: IdInPath, request: Request, parts: PartsOf, shell: ShellOf, _: Reader
) -> Response:
    """Return how far the solve is, as of a sensor."""
    with parts.station.store.look() as session:
        return solving_answer(request, shell, rig_report_of(session, calibration_id))


@router.get(f"{_SENSOR}/figures")
@from_the_store
def get_figures(
    calibration_id: IdInPath, sensor_id: SensorInPath, parts: PartsOf, _: Reader
) -> Response:
    """Return what the drawings of one sensor's pictures are made of."""
    pictures = evidence_of(rig_calibration_points(parts.station, calibration_id, sensor_id))
    size_px = _size_px(parts.station.store, calibration_id, sensor_id)
    return JSONResponse(pictures_drawn(SolvedOnRig.of(pictures), pictures, size_px))


@router.get(f"{_SENSOR}/pictures/{{place}}")
@from_the_store
def get_picture(
    calibration_id: IdInPath,
    sensor_id: SensorInPath,
    place: Annotated[int, Path(ge=0, le=100_000)],
    parts: PartsOf,
    _: Reader,
) -> Response:
    """Return the points of one picture, by its place among those of the sensor."""
    points = rig_calibration_points(parts.station, calibration_id, sensor_id)
    size_px = _size_px(parts.station.store, calibration_id, sensor_id)
    frames = rig_pictures_of(parts.station, calibration_id, sensor_id)
    found = picture_of(SolvedOnRig.of(evidence_of(points)), size_px, points, place, frames)
    if found is None:
        raise NotFound(f"rig calibration {calibration_id} has no picture {place} of {sensor_id}")
    return JSONResponse(found)


def _size_px(store: Store, calibration_id: str, sensor: str) -> tuple[int, int]:
    with store.look() as session:
        text = the(session, RigCalibration, calibration_id).document
    document = RigDocument.model_validate_json(text or "")
    camera = next(each.camera for each in document.sensors if each.sensor == sensor)
    return camera.width, camera.height
