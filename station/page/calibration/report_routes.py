"""The report of a sensor's calibration, and the figures that its drawings are made of."""

from typing import Annotated, Final

from fastapi import APIRouter, Path, Request, Response
from fastapi.responses import HTMLResponse, JSONResponse

from station.api import IdInPath, PartsOf, Reader, for_a_moment, from_the_store
from station.documents import CalibrationDocument
from station.errors import NotFound, StateConflict
from station.operations import Station, calibration_points, pictures_of
from station.page.calibration.figures import figures_of, size_of
from station.page.calibration.pictures import picture_of
from station.page.calibration.report import Report, report_of
from station.page.calibration.solving import solving_answer
from station.page.shell import ShellOf
from station.store import Calibration, the

router = APIRouter(prefix="/calibrations/{calibration_id}")
# A page of its own to print: it bears its style and its pictures in itself, and no script.
_REPORT_HEADERS: Final = {
    "Content-Security-Policy": (
        "default-src 'none'; style-src 'unsafe-inline'; img-src data:; frame-ancestors 'none'"
    ),
}


@router.get("")
def get_report(
    calibration_id: IdInPath, request: Request, parts: PartsOf, shell: ShellOf, _: Reader
) -> Response:
    """Return the report of a sensor's calibration."""
    with parts.station.store.look() as session:
        report = report_of(session, calibration_id)
    return shell.page(request, "calibration/report.html", active="calibration", report=report)


@router.get("/solving")
@for_a_moment
def get_solving(
    calibration_id: IdInPath, request: Request, parts: PartsOf, shell: ShellOf, _: Reader
) -> Response:
    """Return how far the solve is; once it has ended, the whole page is loaded anew."""
    with parts.station.store.look() as session:
        return solving_answer(request, shell, report_of(session, calibration_id))


@router.get("/figures")
@from_the_store
def get_figures(calibration_id: IdInPath, parts: PartsOf, _: Reader) -> Response:
    """Return what the drawings of a report are made of."""
    with parts.station.store.look() as session:
        report = report_of(session, calibration_id)
        present = None if report.present is None else the(session, Calibration, report.present)
    document = _ready(report)
    beside = None
    if present is not None and present.id != calibration_id and present.document is not None:
        beside = CalibrationDocument.model_validate_json(present.document)
    points = calibration_points(parts.station, calibration_id)
    return JSONResponse(figures_of(document, points, beside))


@router.get("/pictures/{place}")
@from_the_store
def get_picture(
    calibration_id: IdInPath,
    place: Annotated[int, Path(ge=0, le=100_000)],
    parts: PartsOf,
    _: Reader,
) -> Response:
    """Return the points of one picture, by its place among those of the report."""
    document = _document(parts.station, calibration_id)
    points = calibration_points(parts.station, calibration_id)
    frames = pictures_of(parts.station, calibration_id)
    found = picture_of(document, size_of(document), points, place, frames)
    if found is None:
        raise NotFound(f"calibration {calibration_id} has no picture {place}")
    return JSONResponse(found)


@router.get("/report")
def get_printable(calibration_id: IdInPath, parts: PartsOf, _: Reader) -> Response:
    """Return the printable report."""
    return HTMLResponse(parts.guiding.report(calibration_id), headers=_REPORT_HEADERS)


def _document(station: Station, calibration_id: str) -> CalibrationDocument:
    with station.store.look() as session:
        return _ready(report_of(session, calibration_id))


def _ready(report: Report) -> CalibrationDocument:
    if not isinstance(report.document, CalibrationDocument):
        raise StateConflict(
            f"calibration {report.id} is {report.row.state}; only a ready one has figures",
            state=report.row.state,
        )
    return report.document
