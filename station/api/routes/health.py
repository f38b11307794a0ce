"""Is it alive, is it ready, what does it count, how is it called."""

from fastapi import APIRouter, Request, Response
from fastapi.responses import HTMLResponse, JSONResponse, PlainTextResponse

from station.api.answers import Health, Readiness
from station.api.callers import Reader
from station.api.contract import contract_of
from station.api.docs import docs_page
from station.api.parts import Parts, PartsOf
from station.errors import StationError
from station.operations import Capture

router = APIRouter(tags=["health"])


@router.get("/healthz")
def get_health() -> Health:
    """Tell that the API answers."""
    return Health(status="alive")


@router.get("/readyz", responses={503: {}})
def get_readiness(parts: PartsOf, response: Response) -> Readiness:
    """Tell which part is ready, and why another is not."""
    found = _readiness(parts)
    response.status_code = 200 if found.ready else 503
    return found


def _readiness(parts: Parts) -> Readiness:
    answers = {"store": "ready", "worker": "ready" if parts.worker_ready() else "not running"}
    try:
        parts.station.store.ensure_answers()
    except Exception:  # noqa: BLE001  whatever the database's driver raises, it is not ready
        answers["store"] = "does not answer"
    for sensor, capture in parts.station.captures.items():
        answers[f"sensor {sensor}"] = _problem(capture) or "ready"
    return Readiness(ready=set(answers.values()) == {"ready"}, parts=answers)


def _problem(capture: Capture) -> str | None:
    try:
        return capture.status().problem
    except StationError as error:
        return str(error)


@router.get("/metrics", response_class=PlainTextResponse)
def get_metrics(parts: PartsOf, _: Reader) -> Response:
    """Return counts for Prometheus."""
    return Response(parts.metrics.text(), media_type="text/plain; version=0.0.4")


@router.get("/openapi.json", include_in_schema=False)
def get_openapi(request: Request, _: Reader) -> JSONResponse:
    """Return the contract."""
    return JSONResponse(contract_of(request.app))


@router.get("/docs", include_in_schema=False)
def get_docs(request: Request, _: Reader) -> HTMLResponse:
    """Return a page of the operations."""
    return HTMLResponse(docs_page(contract_of(request.app)))
