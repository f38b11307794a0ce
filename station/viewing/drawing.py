"""Pictures as browsers show them."""

import cv2
import numpy as np

from calib import Picture

_JPEG_QUALITY = 80
_PNG_EFFORT = 1
"""Noise does not compress: more than the least makes it three times slower, hardly smaller."""


def as_jpeg(picture: Picture) -> bytes:
    """Return a grey picture as JPEG."""
    _, encoded = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
    return encoded.tobytes()


def as_png(picture: Picture) -> bytes:
    """Return a grey picture as PNG."""
    _, encoded = cv2.imencode(".png", picture, [cv2.IMWRITE_PNG_COMPRESSION, _PNG_EFFORT])
    return encoded.tobytes()


def not_wider(picture: Picture, max_width: int | None) -> Picture:
    """Return a picture; one wider than `max_width` made smaller, area by area."""
    height, width = picture.shape
    if max_width is None or width <= max_width:
        return picture
    size = (max_width, max(round(height * max_width / width), 1))
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)
