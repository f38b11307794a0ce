"""A calibration session takes of each pose what the sensor's settings say; a pass never does."""

import pytest

from station.capture import ExposureStep, Trigger
from station.operations.arming import _sequence
from station.settings import SensorSettings

SENSOR = SensorSettings(
    id="left",
    address="127.0.0.2",
    gain_db=3.0,
    laser_output="UserOutput0",
    calibration_exposures=[
        {"exposure_us": 200.0, "laser": False},
        {"exposure_us": 900.0, "gain_db": 6.0},
    ],
)


def test_session_takes_every_exposure_with_the_sensor_s_gain_where_none_is_given():
    assert _sequence(SENSOR, Trigger.SOFTWARE) == (
        ExposureStep(200.0, 3.0, laser=False),
        ExposureStep(900.0, 6.0, laser=True),
    )


@pytest.mark.parametrize("trigger", [Trigger.LINE1, Trigger.FREE])
def test_pass_takes_one_frame_a_trigger(trigger):
    assert _sequence(SENSOR, trigger) == ()


def test_sensor_without_exposures_takes_one_frame_a_command():
    assert _sequence(SensorSettings(id="a", address="127.0.0.2"), Trigger.SOFTWARE) == ()
