"""Solving calibrations, looking at them, and bringing one into force."""

import json
from typing import Annotated

from fastapi import APIRouter, Header, Response
from fastapi.responses import PlainTextResponse

from calib import Target
from station.api.actors import By
from station.api.answers import ActivationModel, CalibrationModel
from station.api.callers import Calibrator, Reader
from station.api.etag import etag_of, version_in
from station.api.list_answers import CalibrationsPage
from station.api.paging import Before, cursor_in
from station.api.parts import PartsOf
from station.api.recalibration_requests import RefusalRequest
from station.api.remembered import from_the_store
from station.api.requests import (
    ActivationRequest,
    CalibrationRequest,
    IdInPath,
    Limit,
    SensorInPath,
)
from station.api.shift_answers import ShiftsModel
from station.operations import (
    CalibrationOrder,
    activate_calibration,
    active_calibration,
    calibration_points,
    order_calibration,
    refuse_calibration,
)
from station.settings import SensorId
from station.store import Calibration, the
from station.store.lists import calibrations_page

router = APIRouter(prefix="/v1", tags=["calibration"])

_RETRY_AFTER_S = "1"


@router.post("/calibrations", status_code=202)
def post_calibration(
    body: CalibrationRequest, parts: PartsOf, _: Calibrator, by: By, response: Response
) -> CalibrationModel:
    """Have a calibration solved, from a session or from recordings."""
    calibration, job = order_calibration(
        parts.station,
        CalibrationOrder(
            sensor=body.sensor,
            method=body.method,
            session=body.session,
            recordings=body.recordings,
            target=None if body.target is None else Target.parse(body.target),
            laser_off=body.laser_off,
        ),
        by=by,
    )
    response.headers["Location"] = f"/v1/jobs/{job.id}"
    response.headers["Retry-After"] = _RETRY_AFTER_S
    return CalibrationModel.of(calibration, None)


@router.get("/calibrations")
def list_calibrations(
    parts: PartsOf,
    _: Reader,
    limit: Limit = 100,
    before: Before = None,
    sensor: SensorId | None = None,
) -> CalibrationsPage:
    """Return calibrations of sensors, the newest first, without their files."""
    with parts.station.store.look() as session:
        page = calibrations_page(session, limit=limit, before=cursor_in(before), sensor=sensor)
    return CalibrationsPage.of(page)


@router.get("/calibrations/{calibration_id}")
def get_calibration(calibration_id: IdInPath, parts: PartsOf, _: Reader) -> CalibrationModel:
    """Return a calibration, with its file when it is ready."""
    with parts.station.store.look() as session:
        row = the(session, Calibration, calibration_id)
    return CalibrationModel.of(row, json.loads(row.document) if row.document else None)


@router.post("/calibrations/{calibration_id}/refusal")
def post_refusal(
    calibration_id: IdInPath, body: RefusalRequest, parts: PartsOf, _: Calibrator, by: By
) -> CalibrationModel:
    """Refuse a calibration: it stays to be looked at, and cannot come into force."""
    row = refuse_calibration(parts.station, calibration_id, why=body.reason, by=by)
    return CalibrationModel.of(row, json.loads(row.document) if row.document else None)


@router.get("/calibrations/{calibration_id}/shifts")
@from_the_store
def get_shifts(calibration_id: IdInPath, parts: PartsOf, _: Reader) -> ShiftsModel:
    """Return by how much readings shift once a calibration is in force."""
    return ShiftsModel.of(calibration_id, parts.guiding.shifts(calibration_id))


@router.get(
    "/calibrations/{calibration_id}/points",
    response_class=PlainTextResponse,
    responses={200: {"content": {"text/csv": {}}}},
)
def get_points(calibration_id: IdInPath, parts: PartsOf, _: Reader) -> Response:
    """Return the points of a calibration as CSV."""
    return Response(calibration_points(parts.station, calibration_id), media_type="text/csv")


@router.get("/sensors/{sensor_id}/active-calibration")
def get_active(
    sensor_id: SensorInPath, parts: PartsOf, _: Reader, response: Response
) -> ActivationModel:
    """Return the calibration in force on a sensor; its ETag is for the next change."""
    activation = active_calibration(parts.station, sensor_id)
    response.headers["ETag"] = etag_of(activation.version)
    return ActivationModel.of(activation)


@router.put("/sensors/{sensor_id}/active-calibration")
def put_active(
    sensor_id: SensorInPath,
    body: ActivationRequest,
    parts: PartsOf,
    _: Calibrator,
    by: By,
    response: Response,
    if_match: Annotated[str | None, Header()] = None,
) -> ActivationModel:
    """Bring a calibration into force."""
    activation = activate_calibration(
        parts.station, sensor_id, body.calibration, seen=version_in(if_match), by=by
    )
    response.headers["ETag"] = etag_of(activation.version)
    return ActivationModel.of(activation)
