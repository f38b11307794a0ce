"""Shows that rig.json gives back the rig it was made of, and how a bad one is refused."""

import json

import numpy as np
import pytest
from rig_recordings import INNER, OUTER, TRUTH, calibration_of, true_rig

from calib import RIG_PARAMETERS, SENSOR_PARAMETERS, Rig
from measure import Survey
from station.documents import RigDocument, SurveyDocument, sensors_of
from station.errors import InputUnusable

SIZE = 2 * len(RIG_PARAMETERS)


@pytest.fixture
def doubtful(rng):
    """A rig with a full covariance, of parameters that differ by ten orders."""
    scale = np.tile(np.logspace(-6, 1, len(RIG_PARAMETERS)), 2)
    root = rng.normal(size=(SIZE, SIZE)) * scale[:, None]
    covariance = root @ root.T
    own = len(SENSOR_PARAMETERS)
    # What the file cannot say is a covariance that a camera's own part contradicts.
    covariance[5:9] = covariance[:, 5:9] = 0.0
    rig = Rig(TRUTH.sensors, covariance)
    assert own < len(RIG_PARAMETERS)
    return true_rig(covariance=covariance.tolist(), sensors=sensors_of(rig, prints()))


def prints():
    return {name: calibration_of(name).fingerprint for name in (INNER, OUTER)}


def test_the_rig_read_again_is_the_rig_written(doubtful, tmp_path):
    doubtful.write(tmp_path / "rig.json")
    read = RigDocument.read(tmp_path / "rig.json")
    assert read.fingerprint == doubtful.fingerprint
    rig = read.to_rig()
    np.testing.assert_array_equal(rig.covariance, doubtful.covariance)
    for known, found in zip(TRUTH.sensors, rig.sensors, strict=True):
        assert found.name == known.name
        pixels = np.array([[900.0, 500.0], [1200.0, 700.0]])
        # A rotation vector and back costs a few of the last of 16 digits of 600 mm.
        np.testing.assert_allclose(found.locate(pixels), known.locate(pixels), atol=1e-9)
        columns = rig.columns(found.name)[: len(SENSOR_PARAMETERS)]
        np.testing.assert_array_equal(
            found.sensor.covariance, rig.covariance[np.ix_(columns, columns)]
        )


def test_it_names_the_calibrations_that_it_rests_on():
    assert true_rig().calibrations == prints()


def test_what_the_survey_does_not_say_is_as_usual():
    survey = true_rig(survey=SurveyDocument(sigma_vibration_mm=0.1)).survey_of_wheels()
    assert survey == Survey(sigma_vibration_mm=0.1)


def test_a_rig_without_a_place_beside_the_track_measures_no_wheels_and_says_why():
    with pytest.raises(InputUnusable) as refusal:
        true_rig(survey=None).survey_of_wheels()
    assert "rig wheel does not say where it stands beside the track" in str(refusal.value)
    assert "calibration of inner that has a mounting" in str(refusal.value)


def _short(said):
    said["covariance"].pop()


def _crooked(said):
    said["covariance"][0] = [1.0] * SIZE


def _negative(said):
    said["covariance"][3][3] = -1.0


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (_short, "covariance has 37 rows; allowed: 38 x 38, 19 a sensor"),
        (_crooked, "covariance is not symmetric"),
        (_negative, "negative variance"),
        (lambda said: said.update(anchor="middle"), "allowed: one of the sensors, inner, outer"),
        (lambda said: said["sensors"][1].update(sensor="inner"), "give each a name of its own"),
        (lambda said: said.update(format="treadline-calibration"), "format: Input should be"),
        (lambda said: said.update(sensors=[]), "sensors: Tuple should have at least 1"),
        (lambda said: said.update(side="middle"), "side: Input should be 'left' or 'right'"),
    ],
)
def test_a_file_that_is_no_rig_is_refused_in_one_line(tmp_path, change, says):
    said = json.loads(true_rig().model_dump_json())
    change(said)
    path = tmp_path / "rig.json"
    path.write_text(json.dumps(said))
    with pytest.raises(InputUnusable) as refusal:
        RigDocument.read(path)
    assert says in str(refusal.value)
    assert "\n" not in str(refusal.value)
