"""Shows that what is told of a frame is true of it: stripe, brightness, focus, size."""

import base64
import json

import cv2
import numpy as np
import pytest
from viewing_samples import HEIGHT, NOON_NS, PEAK, WIDTH, WIDTH_PX, row_of, striped

from station.viewing import Form, SeenFrame, ViewOrder
from station.viewing.finding import Found
from station.viewing.making import content_of

FRAME = SeenFrame(7, 107, NOON_NS, NOON_NS + 5000)


def made(picture, form, max_width=None):
    order = ViewOrder(form, "a.mcap", max_width=max_width, about={"sensor": "left"})
    return content_of(Found(FRAME, lambda: picture), order)


def document(picture):
    return json.loads(made(picture, Form.STRIPE))


def decoded(content):
    return cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)


def test_a_png_is_exact_and_a_jpeg_nearly_so():
    picture = striped(7)
    np.testing.assert_array_equal(decoded(made(picture, Form.PNG)), picture)
    difference = decoded(made(picture, Form.JPEG)).astype(int) - picture
    assert np.abs(difference).mean() < 1.5


@pytest.mark.parametrize(
    ("max_width", "shape"), [(100, (75, 100)), (400, (300, 400)), (16, (12, 16))]
)
def test_only_a_wider_picture_is_made_smaller(max_width, shape):
    for form in (Form.PNG, Form.JPEG):
        assert decoded(made(striped(7), form, max_width)).shape == shape


def test_the_stripe_told_is_where_the_frame_has_it_however_small_its_picture_is():
    told = json.loads(made(striped(7), Form.VIEW, 100))
    stripe, picture = told["stripe"], told["picture"]
    assert (told["sensor"], told["number"], told["frame"]) == ("left", 7, 107)
    assert (told["time"], told["received"]) == (
        "2026-07-01T12:00:00.000000Z",
        "2026-07-01T12:00:00.000005Z",
    )
    assert (told["width_px"], told["height_px"]) == (WIDTH, HEIGHT)
    assert (picture["width_px"], picture["height_px"]) == (100, 75)
    assert decoded(base64.b64decode(picture["base64"])).shape == (75, 100)
    assert len(stripe["u_px"]) == len(stripe["v_px"]) == len(stripe["sigma_px"])
    assert stripe["points"] > 0.9 * WIDTH
    assert np.abs(np.array(stripe["v_px"]) - row_of(7)).max() < 0.2
    assert 0.0 < max(stripe["sigma_px"]) < 0.1
    assert "picture" not in document(striped(7))


def test_no_more_points_are_told_than_can_be_drawn_and_they_span_the_stripe():
    wide = np.tile(striped(7), (1, 4))
    stripe = document(wide)["stripe"]
    assert stripe["points"] > 1400
    assert len(stripe["u_px"]) == 400
    assert min(stripe["u_px"]) < 20
    assert max(stripe["u_px"]) > 4 * WIDTH - 20


def test_focus_is_the_width_and_the_peak_of_the_stripe():
    sharp = document(striped(7))["focus"]
    assert sharp["width_px"] == pytest.approx(WIDTH_PX, rel=0.05)
    assert sharp["peak_counts"] == pytest.approx(PEAK, rel=0.05)
    assert sharp["clipped_share"] == 0.0
    blurred = document(cv2.GaussianBlur(striped(7), (0, 0), 2.0))["focus"]
    assert blurred["width_px"] == pytest.approx(np.hypot(WIDTH_PX, 2.0), rel=0.05)
    assert blurred["peak_counts"] < sharp["peak_counts"]


def test_a_frame_without_a_stripe_has_no_focus():
    told = document(np.full((HEIGHT, WIDTH), 30, np.uint8))
    assert told["focus"] is None
    assert told["stripe"] == {"points": 0, "u_px": [], "v_px": [], "sigma_px": []}


def test_brightness_counts_every_pixel():
    picture = np.full((100, 100), 10, np.uint8)
    picture.ravel()[:5] = 200
    assert document(picture)["brightness"] == {
        "max_counts": 200,
        "p999_counts": 10,
        "clipped_share": 0.0,
    }
    picture.ravel()[:100] = 255
    assert document(picture)["brightness"] == {
        "max_counts": 255,
        "p999_counts": 255,
        "clipped_share": 0.01,
    }
