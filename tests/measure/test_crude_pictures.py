"""Wheels from pictures of another hand: what is measured must not lean on one renderer.

These pictures know no steel: a stripe is as bright on the flange as on the tread.
"""

import cv2
import numpy as np
import pytest
import wheel_stripes as ws
from crude_pictures import Crude, draw

from calib import Cause, locate_stripe
from measure import Quantity, WheelFrame, measure_wheel, reference_profile

SENSOR, RIG = ws.trackside()
MOUNTING = ws.mounting_of(RIG)
QUANTITIES = ("flange_height", "flange_thickness_10", "flange_gradient_qr", "tread_wear")
LOOKS = {
    "gaussian": Crude(),
    "flat-topped": Crude(shape="flat"),
    "long-tailed": Crude(shape="tailed", noise=2.0),
    "clipped": Crude(counts=600.0),
    "clipped, back nearly dark": Crude(counts=900.0, dark_end=0.02),
    "dim and noisy": Crude(counts=25.0, noise=1.5, rows=0.5),
    "gaps": Crude(gaps=4),
    "second stripe": Crude(ghost=0.6),
    "brighter second stripe": Crude(ghost=1.5),
    "blobs": Crude(blobs=15, rows=0.5),
}


@pytest.fixture(scope="module", autouse=True)
def _one_thread():
    cv2.setNumThreads(1)


def measured(look, reference, rng, **wheel):
    worn = ws.Wheel(reference=reference, **wheel)
    stripe = locate_stripe(draw(worn, SENSOR, RIG, look, rng))
    frames = [WheelFrame(stripe, 0, "drawn")]
    answer = measure_wheel(frames, SENSOR, reference_profile(reference), mounting=MOUNTING)
    return answer, worn.truth()


@pytest.mark.parametrize("look", LOOKS)
def test_wheel_drawn_by_another_hand_is_read_within_what_bad_light_is_allowed(look, rng):
    off = []
    for reference, tread_wear_mm, flange_wear_mm in (("S1002", 1.0, 0.5), ("LMA", 5.0, 2.0)):
        answer, truth = measured(
            LOOKS[look],
            reference,
            rng,
            tread_wear_mm=tread_wear_mm,
            flange_wear_mm=flange_wear_mm,
            lateral_mm=float(rng.normal(0.0, 3.0)),
        )
        assert answer.reason is None, answer.reason
        off.append([answer.readings[Quantity(q)].value - truth[q] for q in QUANTITIES])
    # The demand in bad light is 0.05 mm RMS over many wheels; of eight values none is 3 x that.
    assert np.sqrt(np.mean(np.square(off))) <= 0.05
    assert np.abs(off).max() <= 0.12


def test_of_a_second_stripe_the_points_are_told(rng):
    answer, _ = measured(Crude(ghost=0.6), "S1002", rng)
    out = answer.quality.left_out
    # The second stripe is as long as the first.
    assert out.get(Cause.STRAY_LIGHT, 0) + out.get(Cause.GLARE, 0) > 0.5 * answer.quality.points


def test_section_out_of_shape_gives_no_value(rng):
    """As light along another sheet draws it, the true stripe hidden."""
    whole = ws.stripe_on(ws.Wheel(), SENSOR, RIG, rng)
    stripe = ws.make_stripe(whole.centre_px * [0.55, 1.0] + [450.0, 0.0], whole.normal)
    answer = measure_wheel(
        [WheelFrame(stripe, 0, "bent")], SENSOR, reference_profile("S1002"), mounting=MOUNTING
    )
    assert "wheel" in answer.reason
    assert all(reading.value is None for reading in answer.readings.values())
