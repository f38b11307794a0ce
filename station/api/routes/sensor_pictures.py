"""What a sensor sees, and saw last: a picture, or a document of it and what was found on it.

``GET /v1/sensors/{sensor}/view?source=latest&max_width=640`` answers ``application/json``::

    {"sensor": "left", "recording": "pass-7-left", "number": 812, "frame": 812,
     "time": "2026-07-01T12:00:00.123456Z", "received": "2026-07-01T12:00:00.141002Z",
     "width_px": 2048, "height_px": 1088,
     "picture": {"media_type": "image/jpeg", "width_px": 640, "height_px": 340, "base64": "..."},
     "brightness": {"max_counts": 255, "p999_counts": 201, "clipped_share": 0.0002},
     "focus": {"width_px": 2.31, "peak_counts": 143.0, "clipped_share": 0.01},
     "stripe": {"points": 1630, "u_px": [...], "v_px": [...], "sigma_px": [...]}}

The stripe is that of this very picture: at most 400 of its ``points``, in pixels of the whole frame
of ``width_px`` x ``height_px``, (0, 0) being the centre of the top-left one; so an SVG over the
picture has ``viewBox="-0.5 -0.5 width_px height_px"``.  They are in no order to be joined by a line
with: draw dots.  ``focus`` is null where no stripe was found.  Of a look, ``recording``, ``number``
and ``frame`` are null.

``GET /v1/sensors/{sensor}/picture?source=latest&max_width=640`` answers ``image/jpeg``.

Both carry the headers ``Treadline-Recording``, ``Treadline-Number``, ``Treadline-Frame``,
``Treadline-Time`` and ``Treadline-Received``, as far as they apply.

``source=latest``, scope read: the newest frame of the recording being made, or else of the last one
that has any.  It has an ``ETag``: send it back as ``If-None-Match``, and while there is no newer
frame the answer is 304 and nothing was made.  A script sets that header itself (answers are not to
be stored), and gets the 304 to see.  Newer frames come at most 6 times a second.

``source=look``, scope operate or calibrate: the camera takes a picture now, as its settings say; it
is recorded nowhere.  409 with ``state`` unless the sensor is idle, or in a calibration session
between two pictures; a train that comes goes first.

404 where the sensor has recorded nothing, 503 with ``Retry-After: 1`` where too many wait already.
"""

from enum import StrEnum
from typing import Annotated

from fastapi import APIRouter, Header, Query, Response

from station.api.callers import Reader, ensure_may
from station.api.parts import Parts, PartsOf
from station.api.requests import SensorInPath
from station.api.view_answers import (
    ViewModel,
    answer_of,
    known_in,
    not_modified,
)
from station.operations import Shown, sensor_at
from station.store.callers import Caller, Scope
from station.viewing import Form

router = APIRouter(prefix="/v1/sensors/{sensor_id}", tags=["sensors"])


class Source(StrEnum):
    """Where a picture is to come from."""

    LATEST = "latest"
    LOOK = "look"


SourceAsked = Annotated[
    Source, Query(description="The newest recorded frame, or one that the camera takes now.")
]
WidthAsked = Annotated[
    int, Query(ge=16, le=16_384, description="In pixels; a wider one is made smaller.")
]
HasAlready = Annotated[
    str | None, Header(alias="If-None-Match", description="The ETag of the frame that is here.")
]
_SAME: dict[int | str, dict[str, object]] = {304: {"description": "There is no newer frame."}}


@router.get(
    "/picture",
    response_class=Response,
    responses={200: {"content": {Form.JPEG.media_type: {}}}, **_SAME},
)
async def get_sensor_picture(
    sensor_id: SensorInPath,
    parts: PartsOf,
    caller: Reader,
    source: SourceAsked = Source.LATEST,
    max_width: WidthAsked = 640,
    if_none_match: HasAlready = None,
) -> Response:
    """Return what a sensor sees or saw last as a picture (JPEG)."""
    known = known_in(if_none_match)
    shown = await _shown(parts, caller, sensor_id, source, Form.JPEG, max_width, known)
    return not_modified(if_none_match) if shown is None else answer_of(shown)


@router.get("/view", response_class=Response, responses={200: {"model": ViewModel}, **_SAME})
async def get_sensor_view(
    sensor_id: SensorInPath,
    parts: PartsOf,
    caller: Reader,
    source: SourceAsked = Source.LATEST,
    max_width: WidthAsked = 640,
    if_none_match: HasAlready = None,
) -> Response:
    """Return what a sensor sees or saw last, with stripe, brightness and focus of that picture."""
    known = known_in(if_none_match)
    shown = await _shown(parts, caller, sensor_id, source, Form.VIEW, max_width, known)
    return not_modified(if_none_match) if shown is None else answer_of(shown)


async def _shown(
    parts: Parts,
    caller: Caller,
    sensor: str,
    source: Source,
    form: Form,
    max_width: int,
    known: tuple[str, int] | None,
) -> Shown | None:
    showing = parts.showing
    if source is Source.LATEST:
        return await parts.turns.take(
            None, lambda: showing.newest(sensor, form, max_width=max_width, known=known)
        )
    if not caller.may(Scope.CALIBRATE):  # who takes pictures of a target aims it first
        ensure_may(caller, Scope.OPERATE)
    camera_of = sensor_at(parts.station.settings, sensor).id  # no turns for names of nothing
    return await parts.turns.take(
        camera_of, lambda: showing.look(sensor, form, max_width=max_width)
    )
