"""What comes out over HTTP of a frame: a picture, or a document of it."""

import re
from datetime import datetime

from fastapi import Response

from station.api.answers import Out
from station.operations import Shown
from station.viewing import moment

_TAG = re.compile(r'(?:W/)?"(?P<recording>[\w.-]{1,128})\.(?P<number>\d{1,9})"', re.ASCII)
_FOR_GOOD = "private, max-age=86400, immutable"
"""A frame of a closed recording never changes."""


class BrightnessModel(Out):
    """How the counts of a picture are spread."""

    max_counts: int
    p999_counts: int
    """So bright or darker are 99.9 % of the pixels."""
    clipped_share: float
    """Part of the pixels that are as bright as can be counted, 0 to 1."""


class FocusModel(Out):
    """How sharp the stripe is: in focus it is narrowest, and its peak highest."""

    width_px: float
    """Standard deviation of the stripe's profile, median of the points that are not clipped."""
    peak_counts: float
    """Height over the background, median."""
    clipped_share: float
    """Part of the points that are clipped, 0 to 1."""


class StripeModel(Out):
    """Points of the laser's stripe, to be drawn: at most 400."""

    points: int
    """How many were found."""
    u_px: list[float]
    """Columns in the whole frame; (0, 0) is the centre of its top-left pixel."""
    v_px: list[float]
    """Rows."""
    sigma_px: list[float]
    """Standard deviations across the stripe."""


class FrameStripeModel(Out):
    """A frame, without its picture, and what was found on it."""

    sensor: str
    recording: str | None
    """Null of a look."""
    number: int | None
    """Its place in the recording, from 1; null of a look."""
    frame: int | None
    """As the camera numbers them; null of a look."""
    time: datetime
    """When it was exposed; of a look, when it was received."""
    received: datetime
    """When it came, by the station's clock."""
    width_px: int
    """Of the whole frame, however large the picture shown is."""
    height_px: int
    brightness: BrightnessModel
    focus: FocusModel | None
    """Null where no stripe was found."""
    stripe: StripeModel


class PictureModel(Out):
    """A picture within a document."""

    media_type: str
    width_px: int
    height_px: int
    base64: str


class ViewModel(FrameStripeModel):
    """A frame, and what was found on this very frame."""

    picture: PictureModel


def answer_of(shown: Shown) -> Response:
    """Return a frame as its form says; by the tag the caller may ask for a newer one."""
    frame = shown.view.frame
    headers = {
        "Treadline-Time": moment(frame.time_ns),
        "Treadline-Received": moment(frame.received_ns),
    }
    if shown.recording is not None:
        headers |= {
            "ETag": f'"{shown.recording}.{frame.number}"',
            "Treadline-Recording": shown.recording,
            "Treadline-Number": str(frame.number),
            "Treadline-Frame": str(frame.frame_id),
        }
    return Response(shown.view.content, media_type=shown.view.form.media_type, headers=headers)


def answer_for_good(shown: Shown) -> Response:
    """Return a frame of a closed recording; a browser that scrubs back need not ask again."""
    answer = answer_of(shown)
    answer.headers["Cache-Control"] = _FOR_GOOD
    return answer


def not_modified(if_none_match: str | None) -> Response:
    """Return the answer to one who has the newest frame already."""
    return Response(status_code=304, headers={"ETag": if_none_match or "*"})


def known_in(if_none_match: str | None) -> tuple[str, int] | None:
    """Return the recording and the number of the frame that a caller has; None where it has none.

    Tags that are not the station's are of no frame.

    >>> known_in('"pass-7-left.812"')
    ('pass-7-left', 812)
    >>> known_in('"812"') is None
    True
    """
    found = None if if_none_match is None else _TAG.fullmatch(if_none_match.strip())
    return None if found is None else (found["recording"], int(found["number"]))
