from dataclasses import replace

import cv2
import numpy as np
import pytest
from wheel_recordings import true_calibration, views_of

from calib import Target
from station.documents import CameraDocument
from station.scenes import Light, WheelTruth, paper_sensor, target_scenes

TARGET = Target.parse("dots:7x8:12:d=6")
WHEEL = WheelTruth("S1002", tread_wear_mm=2.5, flange_wear_mm=1.5)
POSES = 6


@pytest.fixture(scope="session")
def truth():
    return paper_sensor()


@pytest.fixture(scope="session")
def poses(tmp_path_factory, truth):
    """Pictures of the target in good light, with the laser and without, and the camera's file."""
    folder = tmp_path_factory.mktemp("poses")
    rng = np.random.default_rng(11)
    for name in ("on", "off"):
        (folder / name).mkdir()
    for index, scene in enumerate(target_scenes(rng, truth, TARGET, [Light.GOOD] * POSES)):
        cv2.imwrite(str(folder / "on" / f"pose{index}.png"), scene.render(rng))
        cv2.imwrite(
            str(folder / "off" / f"pose{index}.png"), replace(scene, laser_on=False).render(rng)
        )
    CameraDocument.from_model(truth.camera).write(folder / "camera.json")
    return folder


@pytest.fixture(scope="session")
def calibration():
    """The calibration of a sensor without any doubt."""
    return true_calibration()


@pytest.fixture(scope="session")
def wheel():
    """The wheel that `views` show."""
    return WHEEL


@pytest.fixture(scope="session")
def views():
    """Three pictures of one wheel."""
    return views_of(WHEEL, (-20.0, 0.0, 15.0), np.random.default_rng(3), seed=7)
