"""Errors as problem documents (RFC 9457): the one place that knows which error is which status."""

import structlog
from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from fastapi.responses import JSONResponse
from pydantic import BaseModel
from starlette.exceptions import HTTPException

from calib import CalibError
from station import errors
from station.api import refusals
from station.api.addresses import methods_at
from station.guiding import GuideLost
from station.viewing import ViewerLost

_log = structlog.get_logger()
_MEDIA_TYPE = "application/problem+json"
_CAMERA_BACK_S = 5
_MOST_LINES = 5
_LONGEST_LINE = 300

STATUS_OF: dict[type[Exception], int] = {
    CalibError: 422,
    errors.AccessRefused: 403,
    errors.CameraError: 503,
    errors.DiskFull: 507,
    errors.InputUnusable: 422,
    errors.KeyRefused: 401,
    errors.NotFound: 404,
    errors.NothingMeasurable: 422,
    errors.RecordingError: 500,
    errors.RecordingUnreadable: 422,
    errors.StateConflict: 409,
    errors.StationError: 500,
    errors.StoreUnusable: 503,
    errors.VersionConflict: 412,
    errors.VersionMissing: 428,
    refusals.BodyRefused: 400,
    refusals.BodyTooLarge: 413,
    refusals.BodyTooSlow: 408,
    refusals.IdempotencyKeyReused: 422,
    refusals.PicturesBusy: 503,
    refusals.TooManyBadKeys: 429,
    GuideLost: 503,
    ViewerLost: 503,
}


class Problem(BaseModel):
    """What went wrong, for people in `detail` and for programs in the rest."""

    type: str
    title: str
    status: int
    detail: str
    instance: str
    request: str | None = None
    """The id of the call, as in the X-Request-Id of the answer and in the station's log."""
    state: str | None = None
    """The present state, where that is what forbids the call."""


def status_of(error: Exception) -> int:
    """Return the status of the nearest listed ancestor of an error."""
    return next(STATUS_OF[cls] for cls in type(error).__mro__ if cls in STATUS_OF)


PROBLEMS: dict[int | str, dict[str, object]] = {
    "default": {
        "description": "What went wrong.",
        "content": {_MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/Problem"}}},
    }
}
"""What every operation may answer; for its routes' `responses`."""


def answer_with_problems(app: FastAPI) -> None:
    """Have every error of an app answered by a problem document."""

    async def known(request: Request, error: Exception) -> JSONResponse:
        return problem_answer(request.url.path, error)

    app.add_exception_handler(errors.StationError, known)
    app.add_exception_handler(CalibError, known)
    app.add_exception_handler(RequestValidationError, _answer_invalid)
    app.add_exception_handler(HTTPException, _answer_http)


def problem_answer(path: str, error: Exception) -> JSONResponse:
    """Return the answer to a call at `path` that ended in an error of the table."""
    return _answer(
        path,
        status=status_of(error),
        name=type(error).__name__,
        detail=str(error),
        state=getattr(error, "state", None),
        retry_after_s=getattr(error, "retry_after_s", None),
    )


async def _answer_invalid(request: Request, error: Exception) -> JSONResponse:
    found = error.errors() if isinstance(error, RequestValidationError) else []
    lines = [
        f"{'.'.join(str(part) for part in each['loc'])}: {each['msg']}"[:_LONGEST_LINE]
        for each in found[:_MOST_LINES]
    ]
    if len(found) > _MOST_LINES:
        lines.append(f"and {len(found) - _MOST_LINES} more")
    return _answer(request.url.path, status=422, name="RequestInvalid", detail="; ".join(lines))


async def _answer_http(request: Request, error: Exception) -> JSONResponse:
    status, detail, headers = 500, "", None
    if isinstance(error, HTTPException):
        status, detail, headers = error.status_code, error.detail, error.headers
    path = request.url.path
    lines = {404: f"{path}: no such address", 405: f"{path}: not by {request.method}"}
    answer = _answer(path, status=status, name="HttpError", detail=lines.get(status, detail))
    answer.headers.update(headers or {})
    if status == 405:
        # The framework names those of the first route alone.
        answer.headers["Allow"] = ", ".join(methods_at(request.app, path)) or "GET"
    return answer


def unforeseen_answer(path: str, error: Exception) -> JSONResponse:
    """Log an error that nobody foresaw; return an answer that tells nothing of it."""
    _log.error("request failed unexpectedly", path=path, exc_info=error)
    return _answer(
        path,
        status=500,
        name="InternalError",
        detail="the station failed unexpectedly; its log says more, under the request's id",
    )


def _answer(
    path: str,
    *,
    status: int,
    name: str,
    detail: str,
    state: str | None = None,
    retry_after_s: int | None = None,
) -> JSONResponse:
    problem = Problem(
        type=f"urn:treadline:problem:{name}",
        title=_words(name),
        status=status,
        detail=detail,
        instance=path,
        request=structlog.contextvars.get_contextvars().get("request"),
        state=state,
    )
    headers = {"WWW-Authenticate": "Bearer"} if status == 401 else {}
    if retry_after_s is None and status == 503:
        retry_after_s = _CAMERA_BACK_S
    if retry_after_s is not None:
        headers["Retry-After"] = str(retry_after_s)
    return JSONResponse(
        problem.model_dump(exclude_none=True),
        status_code=status,
        media_type=_MEDIA_TYPE,
        headers=headers,
    )


def _words(name: str) -> str:
    """Return the name of a class as words.

    >>> _words("StateConflict")
    'State conflict'
    """
    spaced = "".join(f" {letter.lower()}" if letter.isupper() else letter for letter in name)
    return spaced.strip().capitalize()
