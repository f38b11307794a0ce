"""Is it alive, is it ready, what does it count, how is it called."""

from fastapi import APIRouter, Request, Response
from fastapi.responses import HTMLResponse, JSONResponse, PlainTextResponse

from station.api.callers import Reader
from station.api.contract import contract_of
from station.api.docs import docs_page
from station.api.health_answers import Health, Readiness
from station.api.parts import PartsOf

router = APIRouter(tags=["health"])
_AGAIN_S = 5
_WHEN_AGAIN = {
    "Retry-After": {"description": "Seconds until a look pays.", "schema": {"type": "integer"}}
}


@router.get("/healthz")
def get_health() -> Health:
    """Tell that the API answers."""
    return Health(status="alive")


@router.get("/readyz", responses={503: {"headers": _WHEN_AGAIN}})
def get_readiness(parts: PartsOf, response: Response) -> Readiness:
    """Tell which part is ready, and why another is not."""
    found = Readiness.of(parts.lookout.look())
    if not found.ready:
        response.status_code = 503
        response.headers["Retry-After"] = str(_AGAIN_S)
    return found


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
