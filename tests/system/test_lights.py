"""Pictures of every light through detection and both solvers, against the true plane."""

import numpy as np
import pytest

from calib import Method
from station.bench.lights import observe_light, sheet_error_mm
from station.scenes import Light, paper_sensor

POSES, SEEDS = 8, (1, 2)
# Asked for 20 poses, RMS over the field; fewer err more by the root.
LIMITS_MM = {Light.GOOD: 0.005}


@pytest.mark.parametrize("light", list(Light))
def test_joint_plane_is_nearer_the_truth_than_the_preplanar_one_in_every_light(light):
    sensor = paper_sensor()
    errors = {method: [] for method in (Method.JOINT, Method.PREPLANAR)}
    for seed in SEEDS:
        views, _ = observe_light(light, sensor, poses=POSES, seed=seed)
        for method, found in errors.items():
            found.append(sheet_error_mm(views, sensor, method))
    # By two draws, for in one the baseline may be lucky.
    joint, baseline = (np.sqrt(np.mean(np.square(found))) for found in errors.values())
    assert joint < baseline
    assert joint < LIMITS_MM.get(light, 0.02) * np.sqrt(20 / POSES)
