"""Calibrating rigs, taking in their files, and bringing one into force."""

import json
from typing import Annotated

from fastapi import APIRouter, Header, Query, Response
from fastapi.responses import PlainTextResponse

from calib import Target
from station.api.actors import By
from station.api.answers import RigActivationModel, RigCalibrationModel
from station.api.callers import Calibrator, Reader
from station.api.etag import etag_of, version_in
from station.api.list_answers import RigCalibrationsPage, RigInForcePage
from station.api.paging import Before, cursor_in
from station.api.parts import PartsOf
from station.api.recalibration_requests import RefusalRequest
from station.api.requests import (
    ActivationRequest,
    IdInPath,
    Limit,
    RigCalibrationRequest,
    RigInPath,
    SensorInPath,
)
from station.documents import RigDocument
from station.operations import (
    RigCalibrationOrder,
    activate_rig_calibration,
    active_rig_calibration,
    keep_rig_calibration,
    order_rig_calibration,
    refuse_rig_calibration,
    rig_at,
    rig_calibration_points,
)
from station.settings import SensorId
from station.store import RigCalibration, the
from station.store.lists import rig_activations_page, rig_calibrations_page

router = APIRouter(prefix="/v1", tags=["calibration"])

_RETRY_AFTER_S = "1"
_LARGEST_VERSION = 2**31 - 1


@router.post("/rig-calibrations", status_code=202)
def post_rig_calibration(
    body: RigCalibrationRequest, parts: PartsOf, _: Calibrator, by: By, response: Response
) -> RigCalibrationModel:
    """Have a rig calibrated, from a session or from recordings of its sensors."""
    calibration, job = order_rig_calibration(
        parts.station,
        RigCalibrationOrder(
            rig=body.rig,
            session=body.session,
            recordings=body.recordings,
            target=None if body.target is None else Target.parse(body.target),
            targets={name: Target.parse(text) for name, text in body.targets.items()},
            same_board=body.same_board,
            board_sigma_mm=body.board_sigma_mm,
        ),
        by=by,
    )
    response.headers["Location"] = f"/v1/jobs/{job.id}"
    response.headers["Retry-After"] = _RETRY_AFTER_S
    return RigCalibrationModel.of(calibration, None)


@router.post("/rig-calibrations/files", status_code=201)
def post_rig_file(
    body: RigDocument, parts: PartsOf, _: Calibrator, by: By, response: Response
) -> RigCalibrationModel:
    """Take in a rig.json that was made elsewhere."""
    calibration = keep_rig_calibration(parts.station, body, by=by)
    response.headers["Location"] = f"/v1/rig-calibrations/{calibration.id}"
    return RigCalibrationModel.of(calibration, body.model_dump(mode="json"))


@router.get("/rig-calibrations")
def list_rig_calibrations(
    parts: PartsOf,
    _: Reader,
    limit: Limit = 100,
    before: Before = None,
    rig: SensorId | None = None,
) -> RigCalibrationsPage:
    """Return calibrations of rigs, the newest first, without their files."""
    with parts.station.store.look() as session:
        page = rig_calibrations_page(session, limit=limit, before=cursor_in(before), rig=rig)
    return RigCalibrationsPage.of(page)


@router.get("/rig-calibrations/{calibration_id}")
def get_rig_calibration(calibration_id: IdInPath, parts: PartsOf, _: Reader) -> RigCalibrationModel:
    """Return a rig's calibration, with its file when it is ready."""
    with parts.station.store.look() as session:
        row = the(session, RigCalibration, calibration_id)
    return RigCalibrationModel.of(row, json.loads(row.document) if row.document else None)


@router.get(
    "/rig-calibrations/{calibration_id}/points/{sensor_id}",
    response_class=PlainTextResponse,
    responses={200: {"content": {"text/csv": {}}}},
)
def get_rig_points(
    calibration_id: IdInPath, sensor_id: SensorInPath, parts: PartsOf, _: Reader
) -> Response:
    """Return the points of one sensor's pictures in a rig's calibration as CSV."""
    text = rig_calibration_points(parts.station, calibration_id, sensor_id)
    return Response(text, media_type="text/csv")


@router.post("/rig-calibrations/{calibration_id}/refusal")
def post_rig_refusal(
    calibration_id: IdInPath, body: RefusalRequest, parts: PartsOf, _: Calibrator, by: By
) -> RigCalibrationModel:
    """Refuse a calibration of a rig: it stays to be looked at, and cannot come into force."""
    row = refuse_rig_calibration(parts.station, calibration_id, why=body.reason, by=by)
    return RigCalibrationModel.of(row, json.loads(row.document) if row.document else None)


@router.get("/rigs/{rig_id}/calibrations")
def list_rig_in_force(
    rig_id: RigInPath,
    parts: PartsOf,
    _: Reader,
    limit: Limit = 100,
    before: Annotated[
        int | None, Query(ge=1, le=_LARGEST_VERSION, description="`next` of a page.")
    ] = None,
) -> RigInForcePage:
    """Return the calibrations that came into force on a rig, the last one first."""
    rig_at(parts.station.settings, rig_id)
    with parts.station.store.look() as session:
        page = rig_activations_page(session, rig_id, limit=limit, before=before)
    return RigInForcePage.of(rig_id, page)


@router.get("/rigs/{rig_id}/active-calibration")
def get_active_rig(
    rig_id: RigInPath, parts: PartsOf, _: Reader, response: Response
) -> RigActivationModel:
    """Return the calibration in force on a rig; its ETag is for the next change."""
    activation = active_rig_calibration(parts.station, rig_id)
    response.headers["ETag"] = etag_of(activation.version)
    return RigActivationModel.of(activation)


@router.put("/rigs/{rig_id}/active-calibration")
def put_active_rig(
    rig_id: RigInPath,
    body: ActivationRequest,
    parts: PartsOf,
    _: Calibrator,
    by: By,
    response: Response,
    if_match: Annotated[str | None, Header()] = None,
) -> RigActivationModel:
    """Bring a calibration of a rig into force."""
    activation = activate_rig_calibration(
        parts.station, rig_id, body.calibration, seen=version_in(if_match), by=by
    )
    response.headers["ETag"] = etag_of(activation.version)
    return RigActivationModel.of(activation)
