"""Does the station of the demo read its settings as they are meant?"""

import tomllib

import numpy as np

from station.demo.scenario import Scenario
from station.demo.trackside import settings_toml
from station.settings import StationSettings


def test_settings_have_two_rigs_of_two_sensors_and_the_survey_of_their_anchors(tmp_path):
    scenario = Scenario.draw(2)
    text = settings_toml(scenario, tmp_path, 8080)
    settings = StationSettings.model_validate(tomllib.loads(text))
    assert [rig.id for rig in settings.rigs] == ["left", "right"]
    for rig, truth in zip(settings.rigs, scenario.rigs, strict=True):
        assert rig.sensors == tuple(sensor.id for sensor in truth.sensors)
        assert settings.anchor_of(rig) == truth.anchor.id
        assert settings.side_of(rig) == truth.side
        mounting = settings.sensor(truth.anchor.id).mounting
        np.testing.assert_allclose(
            mounting.translation_mm, truth.anchor.rig_from_camera.translation_mm
        )
        assert settings.sensor(truth.sensors[1].id).mounting is None
