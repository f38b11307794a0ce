"""The hand-made protobuf is the library's, byte for byte, and is read in any order of fields."""

import contextlib

import numpy as np
import pytest
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from hypothesis import given
from hypothesis import strategies as st

from station.recording.rawimage import raw_image_around, read_raw_image

sizes = st.integers(1, 40)
times = st.integers(0, 2**62)


def by_the_library(time_ns, frame, width, height, data):
    message = RawImage(
        frame_id=frame, width=width, height=height, encoding="mono8", step=width, data=data
    )
    message.timestamp.FromNanoseconds(time_ns)
    return message


@given(times, st.text(max_size=20), sizes, sizes)
def test_message_around_a_picture_equals_the_librarys(time_ns, frame, width, height):
    data = bytes(n % 251 for n in range(width * height))
    head, tail = raw_image_around(time_ns, frame, width, height, len(data))
    expected = by_the_library(time_ns, frame, width, height, data)
    assert head + data + tail == expected.SerializeToString()


def test_full_size_picture_is_framed_like_the_librarys(rng):
    pixels = rng.integers(0, 256, 2048 * 1088, dtype=np.uint8).tobytes()
    head, tail = raw_image_around(1, "left", 2048, 1088, len(pixels))
    assert head + pixels + tail == by_the_library(1, "left", 2048, 1088, pixels).SerializeToString()


@given(times, st.text(max_size=20), sizes, sizes)
def test_message_of_the_library_is_read(time_ns, frame, width, height):
    data = bytes(width * height)
    message = by_the_library(time_ns, frame, width, height, data).SerializeToString()
    image = read_raw_image(memoryview(message))
    assert (image.time_ns, image.frame, image.encoding) == (time_ns, frame, "mono8")
    assert (image.width, image.height, image.step) == (width, height, width)
    assert image.data == data


def test_fields_may_come_in_any_order():
    data = by_the_library(7, "left", 2, 1, b"ab")
    parts = [RawImage(data=b"ab"), RawImage(width=2, height=1, step=2), RawImage(encoding="mono8")]
    message = b"".join(part.SerializeToString() for part in parts)
    image = read_raw_image(memoryview(message))
    assert (image.width, image.height, bytes(image.data)) == (data.width, data.height, data.data)


@given(st.binary(max_size=60))
def test_bytes_that_are_no_message_are_a_value_error_at_worst(data):
    with contextlib.suppress(ValueError):
        read_raw_image(memoryview(data))


@pytest.mark.parametrize("cut", [1, 5, 20, 40])
def test_message_cut_short_is_refused_or_has_no_data(cut):
    message = by_the_library(7, "left", 20, 3, bytes(60)).SerializeToString()[:cut]
    try:
        image = read_raw_image(memoryview(message))
    except ValueError:
        return
    assert len(image.data) == 0
