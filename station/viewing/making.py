"""Making of a frame what was asked for."""

import base64
import json
from typing import Any

from calib import Picture, locate_stripe
from station.viewing.drawing import as_jpeg, as_png, not_wider
from station.viewing.finding import Found
from station.viewing.judging import Brightness, focus_json, stripe_json
from station.viewing.moments import moment
from station.viewing.orders import Form, SeenFrame, ViewOrder
from station.viewing.timeline import timeline_json


def content_of(found: Found, order: ViewOrder) -> bytes:
    """Return a frame in the form of an order."""
    if order.form is Form.TIMELINE:
        return _encoded({**order.about, **timeline_json(found.table, order.frame_ids)})
    picture = found.picture()
    match order.form:
        case Form.JPEG:
            return as_jpeg(not_wider(picture, order.max_width))
        case Form.PNG:
            return as_png(not_wider(picture, order.max_width))
        case Form.VIEW:
            shown = _picture_json(not_wider(picture, order.max_width))
            return _encoded({**_document(found.frame, picture, order), "picture": shown})
        case Form.STRIPE:
            return _encoded(_document(found.frame, picture, order))


def _document(frame: SeenFrame, picture: Picture, order: ViewOrder) -> dict[str, Any]:
    stripe = locate_stripe(picture)
    height, width = picture.shape
    return {
        **order.about,
        "number": frame.number,
        "frame": frame.frame_id,
        "time": moment(frame.time_ns),
        "received": moment(frame.received_ns),
        "width_px": width,
        "height_px": height,
        "brightness": Brightness.of(picture).to_json(),
        "focus": focus_json(stripe),
        "stripe": stripe_json(stripe),
    }


def _picture_json(shown: Picture) -> dict[str, Any]:
    height, width = shown.shape
    return {
        "media_type": Form.JPEG.media_type,
        "width_px": width,
        "height_px": height,
        "base64": base64.b64encode(as_jpeg(shown)).decode(),
    }


def _encoded(document: dict[str, Any]) -> bytes:
    return json.dumps(document, separators=(",", ":"), allow_nan=False).encode()
