"""Calibrating sensors anew, what came of it, and answering what it asks."""

from typing import Annotated

from fastapi import APIRouter, Header, Query, Response

from station.api.actors import By
from station.api.callers import Calibrator, Reader
from station.api.etag import etag_of, version_in
from station.api.paging import Before, cursor_in
from station.api.parts import PartsOf
from station.api.recalibration_answers import (
    InForcePage,
    RecalibrationModel,
    RecalibrationsPage,
)
from station.api.recalibration_requests import AnswerRequest, RecalibrationRequest
from station.api.requests import IdInPath, Limit, SensorInPath
from station.operations import (
    RecalibrationOrder,
    answer_recalibration,
    order_recalibration,
    sensor_at,
)
from station.store import Recalibration, the
from station.store.lists import activations_page, recalibrations_page
from station.store.recalibrations import reasons_for

router = APIRouter(prefix="/v1", tags=["calibration"])

_RETRY_AFTER_S = "2"
_LARGEST_VERSION = 2**31 - 1


@router.post("/recalibrations", status_code=202)
def post_recalibration(
    body: RecalibrationRequest, parts: PartsOf, _: Calibrator, by: By, response: Response
) -> RecalibrationModel:
    """Have a sensor recalibrated, from its new pictures or from the sessions named."""
    row, job = order_recalibration(
        parts.station, RecalibrationOrder(sensor=body.sensor, sessions=body.sessions), by=by
    )
    response.headers["Location"] = f"/v1/jobs/{job.id}"
    response.headers["Retry-After"] = _RETRY_AFTER_S
    return RecalibrationModel.of(row)


@router.get("/recalibrations/{recalibration_id}")
def get_recalibration(
    recalibration_id: IdInPath, parts: PartsOf, _: Reader, response: Response
) -> RecalibrationModel:
    """Return what was found and decided; its ETag is for the answer."""
    with parts.station.store.look() as session:
        row = the(session, Recalibration, recalibration_id)
    response.headers["ETag"] = etag_of(row.version)
    return RecalibrationModel.of(row)


@router.post("/recalibrations/{recalibration_id}/decision")
def decide_recalibration(
    recalibration_id: IdInPath,
    body: AnswerRequest,
    parts: PartsOf,
    _: Calibrator,
    by: By,
    response: Response,
    if_match: Annotated[str | None, Header()] = None,
) -> RecalibrationModel:
    """Answer a recalibration that asks: bring its calibration into force, or refuse it."""
    row = answer_recalibration(
        parts.station,
        recalibration_id,
        bring=body.action == "activate",
        why=body.reason,
        seen=version_in(if_match),
        by=by,
    )
    response.headers["ETag"] = etag_of(row.version)
    return RecalibrationModel.of(row)


@router.get("/sensors/{sensor_id}/calibrations")
def list_in_force(
    sensor_id: SensorInPath,
    parts: PartsOf,
    _: Reader,
    limit: Limit = 100,
    before: Annotated[
        int | None, Query(ge=1, le=_LARGEST_VERSION, description="`next` of a page.")
    ] = None,
) -> InForcePage:
    """Return the calibrations that came into force on a sensor, the last one first, and why."""
    sensor_at(parts.station.settings, sensor_id)
    with parts.station.store.look() as session:
        page = activations_page(session, sensor_id, limit=limit, before=before)
        return InForcePage.of(sensor_id, page, reasons_for(session, page.rows))


@router.get("/sensors/{sensor_id}/recalibrations")
def list_recalibrations(
    sensor_id: SensorInPath,
    parts: PartsOf,
    _: Reader,
    limit: Limit = 100,
    before: Before = None,
) -> RecalibrationsPage:
    """Return the recalibrations of a sensor, the newest first."""
    sensor_at(parts.station.settings, sensor_id)
    with parts.station.store.look() as session:
        page = recalibrations_page(session, sensor_id, limit=limit, before=cursor_in(before))
    return RecalibrationsPage.of(page)
