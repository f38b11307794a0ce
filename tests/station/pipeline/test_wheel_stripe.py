"""How far down the stripe on a wheel is looked for; what it is then worth is measured elsewhere."""

import numpy as np
import pytest

from calib import locate_stripe
from station.pipeline import locate_wheel_stripe, wheel_stripe
from station.scenes import Light, WheelScene, WheelTruth, paper_sensor, trackside_mounting


def picture(light, **changes):
    scene = WheelScene(
        paper_sensor(), trackside_mounting("left"), WheelTruth(), light=light, seed=3, **changes
    )
    return scene.render(np.random.default_rng(7))


def left_of_the_flange(stripe):
    # In these pictures the flange back is what lies left of column 780.
    return int((stripe.centre_px[:, 0] < 780.0).sum())


def test_flange_back_of_a_dim_wheel_is_found():
    dim = picture(Light.DIM)
    # 45 mm of back face are 150 px long.
    assert left_of_the_flange(locate_stripe(dim)) < 60
    assert left_of_the_flange(locate_wheel_stripe(dim)) > 100


@pytest.mark.parametrize("light", [Light.GOOD, Light.STRAY])
def test_bright_wheel_is_looked_at_once(light, monkeypatch):
    looks = []

    def look(seen, **options):
        looks.append(options)
        return locate_stripe(seen, **options)

    monkeypatch.setattr(wheel_stripe, "locate_stripe", look)
    bright = picture(light)
    np.testing.assert_array_equal(
        locate_wheel_stripe(bright).centre_px, locate_stripe(bright).centre_px
    )
    assert looks == [{}]


def test_dark_picture_has_no_stripe():
    assert len(locate_wheel_stripe(picture(Light.GOOD, laser_on=False))) < 100
