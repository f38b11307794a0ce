"""Frames with a stripe that tells which one it is, and recordings of them."""

import numpy as np

NOON_NS = 1_782_907_200_000_000_000
WIDTH, HEIGHT = 400, 300
PEAK, WIDTH_PX = 150.0, 2.0


def row_of(number):
    """Return the row on which a frame has its stripe."""
    return 60.0 + 7.25 * number


def striped(number):
    """Return a frame with a level stripe; its noise is that of no other."""
    rows = np.arange(HEIGHT)[:, None]
    bell = PEAK * np.exp(-0.5 * ((rows - row_of(number)) / WIDTH_PX) ** 2)
    noise = np.random.default_rng(number).normal(20.0, 1.5, (HEIGHT, WIDTH))
    return np.clip(np.rint(bell + noise), 0, 255).astype(np.uint8)


def write_striped(writer, numbers, *sensor):
    """Write frames that the camera calls 100 more than their number."""
    for number in numbers:
        moment = NOON_NS + number * 1_000_000
        view = striped(number).data.cast("B")
        writer.write_frame(*sensor, 100 + number, moment, moment + 5000, view, WIDTH, HEIGHT)
