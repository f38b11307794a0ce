"""Do the true readings of a wheel follow from its true profile?"""

import numpy as np
import pytest

from station.scenes import WheelTruth


def test_unworn_s1002_reads_what_the_standard_says():
    readings = WheelTruth("S1002").readings
    # The outline is sampled every 0.05 mm: on an arc of 12 mm that is 3e-5 mm.
    assert readings.flange_height == pytest.approx(28.000, abs=5e-4)
    assert readings.flange_thickness_10 == pytest.approx(32.500, abs=5e-4)
    assert readings.flange_thickness_12 == pytest.approx(31.573, abs=5e-4)
    assert readings.flange_gradient_qr == pytest.approx(10.794, abs=5e-4)
    assert readings.tread_wear == 0.0


def test_unworn_lma_reads_what_is_published():
    readings = WheelTruth("LMA").readings
    assert readings.flange_height == pytest.approx(28.0, abs=5e-4)
    assert readings.flange_thickness_12 == pytest.approx(31.974, abs=1e-3)
    assert readings.flange_thickness_10 == pytest.approx(32.900, abs=1e-3)
    assert readings.flange_gradient_qr == pytest.approx(9.739, abs=1e-3)


@pytest.mark.parametrize("reference", ["S1002", "LMA"])
@pytest.mark.parametrize(("tread", "flange"), [(0.0, 0.0), (2.5, 0.0), (0.0, 3.0), (8.0, 6.0)])
def test_tread_wear_is_what_was_asked_for_and_the_profile_stays_a_wheels(reference, tread, flange):
    wheel = WheelTruth(reference, tread, flange)
    assert wheel.readings.tread_wear == pytest.approx(tread, abs=1e-4)
    y = wheel.profile.points_mm[:, 0]
    assert (np.diff(y) >= 0.0).all()  # nothing overhangs
    assert y[0] == -70.0


def test_flange_wear_takes_as_much_off_the_thickness():
    new, worn = WheelTruth("S1002").readings, WheelTruth("S1002", 0.0, 3.0).readings
    assert new.flange_thickness_10 - worn.flange_thickness_10 == pytest.approx(3.0, abs=1e-3)
    assert worn.flange_gradient_qr < new.flange_gradient_qr


def test_wear_makes_the_profile_no_rougher():
    """A kink would show as a jump of the slope between neighbouring points, 0.05 mm apart."""
    normals = WheelTruth("S1002", 4.0, 3.0).profile.normals
    front = normals[:, 0] > -0.999
    turns = np.degrees(np.arccos(np.clip((normals[1:] * normals[:-1]).sum(axis=1), -1.0, 1.0)))
    # The tightest arc of the new profile (12 mm) turns by 0.24 degrees a point; the polynomial's
    # joints by a little more; the square corner of the field face is left out.
    assert turns[front[1:]][:-700].max() < 1.0


def test_normals_point_out_of_the_steel():
    profile = WheelTruth("S1002").profile
    tip = int(np.argmax(profile.points_mm[:, 1]))
    np.testing.assert_allclose(profile.normals[tip], [0.0, 1.0], atol=5e-3)
    np.testing.assert_allclose(profile.normals[10], [-1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(profile.normals[-10], [1.0, 0.0], atol=1e-12)


@pytest.mark.parametrize(
    "wrong",
    [{"tread_wear_mm": 9.0}, {"flange_wear_mm": -0.1}, {"radius_mm": np.nan}],
)
def test_impossible_wheel_is_refused_with_what_is_allowed(wrong):
    with pytest.raises(ValueError, match=f"{next(iter(wrong))}.*allowed"):
        WheelTruth(**wrong)
