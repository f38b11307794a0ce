"""Pictures whose every byte tells where it belongs; importable by a camera's own process."""

import numpy as np

from station.simulated import ArraySource


def numbered_pictures(count, width, height, seed=7):
    return [
        np.random.default_rng([seed, i]).integers(0, 256, (height, width), dtype=np.uint8)
        for i in range(count)
    ]


def numbered_source(count, width, height, seed=7):
    return ArraySource(numbered_pictures(count, width, height, seed))
