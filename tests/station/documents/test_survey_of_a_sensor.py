import pytest
from pydantic import ValidationError

from calib import RigidTransform
from measure import Mounting
from station.documents import MountingDocument
from station.settings import MountingSettings

PLACE = {"rotation_vector": (0.1, -0.2, 0.3), "translation_mm": (500.0, -100.0, -200.0)}


def survey(**said):
    return MountingDocument.from_settings(MountingSettings(**PLACE, **said)).mounting()


def test_what_a_survey_knows_of_axles_reaches_the_readings():
    known = {
        "sigma_radius_mm": 2.0,
        "sigma_axle_x_mm": 15.0,
        "sigma_height_mm": 0.3,
        "sigma_axle_direction_rad": 1e-4,
    }
    mounting = survey(**known)
    assert {name: getattr(mounting, name) for name in known} == known


def test_what_a_survey_does_not_say_is_as_usual():
    usual, said = Mounting(RigidTransform.identity()), survey(sigma_height_mm=0.3)
    assert said.sigma_height_mm == 0.3
    assert said.sigma_radius_mm == usual.sigma_radius_mm
    assert said.sigma_axle_direction_rad == usual.sigma_axle_direction_rad
    assert said.wheel_radius_mm == usual.wheel_radius_mm


def test_a_sigma_of_nothing_is_refused():
    with pytest.raises(ValidationError, match="greater than 0"):
        MountingSettings(**PLACE, sigma_height_mm=0.0)
