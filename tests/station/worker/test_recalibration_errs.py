"""Shows how often a recalibration errs: real calibrations of a sensor at rest and of one that has
moved, solved from points with known noise.  The tables of decisions are shown in another file."""

from dataclasses import replace

import numpy as np
import pytest
from sensor_points import SIZE_PX, TARGET, turned, write_points

from calib import CameraMismatch, compare_sensors, compare_sheets, compare_update
from station.pipeline import calibrate_sources, working_pixels
from station.recalibration import Evidence, NewCalibration, Outcome, decide
from station.scenes import paper_sensor
from station.settings import GateSettings, PolicySettings
from station.worker.comparing import sheet_difference, whole_difference

FEW, MANY = 12, 400
SOUND = NewCalibration(poses=10, rms_dots_px=0.05, rms_stripe_px=0.1, pictures_age_h=1.0)


class Sky:
    """Calibrates a sensor again and again."""

    def __init__(self, folder, rng):
        self._path = folder / "points.csv"
        self._rng = rng

    def calibrate(self, sensor, camera=None, poses=10):
        write_points(self._path, sensor, self._rng, count=poses)
        size = SIZE_PX if camera is None else None
        found = calibrate_sources([self._path], TARGET, sensor="left", camera=camera, size_px=size)
        return found.document

    def pair(self, by_rad=0.0):
        present = self.calibrate(paper_sensor())
        moved = turned(paper_sensor(), by_rad) if by_rad else paper_sensor()
        return present, self.calibrate(moved, present.camera.model())


@pytest.fixture
def sky(tmp_path, rng):
    return Sky(tmp_path, rng)


def outcome_of(present, new, gates):
    evidence = Evidence(
        new=SOUND,
        sheet=sheet_difference(present, new),
        whole=whole_difference(present, new, camera_kept=True),
    )
    return decide(evidence, gates, PolicySettings()).outcome


def scatter_against_expectation(sky, pairs):
    """Return mean square difference over its expectation, of sheets and of whole sensors."""
    seen = []
    for _ in range(pairs):
        present, new = sky.pair()
        told = sheet_difference(present, new), whole_difference(present, new, camera_kept=True)
        seen.append([(each.rms_mm / each.expected_mm) ** 2 for each in told])
    return np.mean(seen, axis=0)


def check_scatter(sky, pairs):
    # A mean square of one normal variable scatters by 1.41 of itself, of more by less; the mean
    # over the pairs by 1.41 / sqrt(pairs), of which four are allowed.
    allowed = 4.0 * np.sqrt(2.0 / pairs)
    for ratio in scatter_against_expectation(sky, pairs):
        assert ratio == pytest.approx(1.0, abs=allowed)


def test_differences_of_a_sensor_at_rest_scatter_as_expected(sky):
    check_scatter(sky, FEW)


@pytest.mark.slow
def test_differences_of_a_sensor_at_rest_scatter_as_expected_in_many_nights(sky):
    check_scatter(sky, MANY)


def false_alarms(sky, pairs, gates):
    differing = {Outcome.SHIFTED, Outcome.DRIFTED}
    return sum(outcome_of(*sky.pair(), gates) in differing for _ in range(pairs))


@pytest.mark.slow
def test_false_alarms_are_no_more_often_than_the_settings_say(sky):
    # At most 0.1: of 400 nights 40, and four times the root of 36 more by chance.
    assert false_alarms(sky, MANY, GateSettings(false_alarm=0.1)) <= 40 + 24


def test_sensor_at_rest_raises_no_alarm(sky):
    # At 0.001, or less, of a night: in 12 nights once in 80 trials.
    assert false_alarms(sky, FEW, GateSettings()) == 0


def test_drift_that_matters_is_found(sky):
    # 1e-3 rad at half a metre and more: over 0.3 mm in the field, where 0.1 matters and 0.03 shows.
    for _ in range(4):
        assert outcome_of(*sky.pair(1e-3), GateSettings()) is Outcome.DRIFTED


def test_sheets_tell_of_smaller_motions_than_whole_sensors_do(sky):
    told = [
        (sheet_difference(*pair).expected_mm, whole_difference(*pair, camera_kept=True).expected_mm)
        for pair in (sky.pair() for _ in range(5))
    ]
    sheets, wholes = np.median(told, axis=0)
    assert sheets < 0.3 * wholes


def test_camera_as_a_prior_counts_once_not_twice(sky):
    present, new = sky.pair()
    pixels = working_pixels([present, new])
    one, other = present.laser_sensor(), new.laser_sensor()
    together = compare_update(one, other, pixels).expected_mm
    assert together < compare_sensors(one, other, pixels).expected_mm


def test_sheet_that_is_the_same_in_both_does_not_differ(sky):
    document = sky.calibrate(paper_sensor())
    sensor = document.laser_sensor()
    found = compare_sheets(sensor, sensor, working_pixels([document]))
    np.testing.assert_allclose(found.difference_mm, 0.0, atol=1e-9)
    assert (found.sigma_mm > 0.0).all()


def test_cameras_of_two_sizes_are_not_compared():
    sensor = paper_sensor()
    other = replace(sensor, camera=replace(sensor.camera, width=640))
    for compare in (compare_sheets, compare_update):
        with pytest.raises(CameraMismatch, match="no pixel in common"):
            compare(sensor, other, np.zeros((1, 2)))
