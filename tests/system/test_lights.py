"""Pictures of every light through detection and both solvers, against the true plane."""

import numpy as np
import pytest

from calib import Method
from station.bench.lights import observe_light, sheet_error_mm
from station.scenes import Light, paper_sensor

POSES = 8


@pytest.mark.parametrize("light", list(Light))
def test_joint_plane_is_nearer_the_truth_than_the_preplanar_one_in_every_light(light):
    sensor = paper_sensor()
    views, _ = observe_light(light, sensor, poses=POSES, seed=1)
    joint = sheet_error_mm(views, sensor, Method.JOINT)
    assert joint < sheet_error_mm(views, sensor, Method.PREPLANAR)
    assert np.isfinite(joint)
