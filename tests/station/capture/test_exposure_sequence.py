"""One command takes every frame of an exposure sequence, and the recording says which is which."""

import numpy as np
import pytest
from capture_rig import capture_of, is_idle, plan_for, sensor_at, wait_for

from station.capture import ExposureStep
from station.capture.sequence import Sequencer
from station.errors import CameraError, CameraRefused
from station.pipeline import read_frames
from station.recording import EventKind, events, verify
from station.simulated import Faults, SimulatedCamera

ADDRESS = "127.20.5.1"
STEPS = (
    ExposureStep(1000.0, 0.0, laser=False),
    ExposureStep(1000.0, 0.0, laser=True),
    ExposureStep(200.0, 6.0, laser=True),
)


class Lamp:
    """A scene as bright as its exposure: 100 counts of daylight, 50 of laser at 1 ms and 0 dB."""

    width, height = 64, 48

    def frame(self, index, exposure_us):
        return self._grey(150.0, exposure_us)

    def frame_laser_off(self, index, exposure_us):
        return self._grey(100.0, exposure_us)

    def _grey(self, level, exposure_us):
        return np.full((self.height, self.width), round(level * exposure_us / 1000.0), np.uint8)


@pytest.fixture
def lit(tmp_path):
    """Yield the client of a sensor before a lamp, and the camera."""
    settings = sensor_at(ADDRESS, laser_output="UserOutput0", exposure_us=500.0)
    with SimulatedCamera(ADDRESS, Lamp()) as camera, capture_of(settings, tmp_path) as (client, _):
        wait_for(client, is_idle)
        yield client, camera


def test_each_command_takes_the_whole_sequence_and_each_frame_says_how(tmp_path, lit):
    client, camera = lit
    path = tmp_path / "a.mcap"
    client.arm(plan_for(path, "software", sequence=STEPS))
    assert [client.trigger() for _ in range(2)] == [3, 6]
    report = client.finish()
    assert (report.triggered, report.recorded, report.complete) == (6, 6, True)
    assert camera.statistics().exposed == 6
    seen = list(read_frames([path]))
    levels = [int(frame.picture[0, 0]) for frame in seen]
    assert levels == 2 * [100, 150, round(150 * 0.2 * 10 ** (6 / 20))]
    how = [(f.exposure.exposure_us, f.exposure.gain_db, f.exposure.laser) for f in seen]
    assert how == 2 * [(1000.0, 0.0, False), (1000.0, 0.0, True), (200.0, 6.0, True)]
    assert [frame.exposure.group for frame in seen] == [1, 1, 1, 2, 2, 2]
    assert verify(path).ok


def test_step_out_of_range_is_refused_and_the_next_command_begins_a_new_group(tmp_path, lit):
    client, _ = lit
    path = tmp_path / "b.mcap"
    steps = (STEPS[0], ExposureStep(1.0))
    client.arm(plan_for(path, "software", sequence=steps))
    for _ in range(2):
        with pytest.raises(CameraRefused, match="exposure 1 us is asked .* it takes 10 to"):
            client.trigger()
    report = client.finish()
    # The first frame of each group was commanded and came: nothing is unexplained.
    assert (report.triggered, report.recorded, report.complete) == (2, 2, True)
    assert [frame.exposure.group for frame in read_frames([path])] == [1, 2]


def test_pass_after_a_sequence_is_exposed_as_the_settings_say(tmp_path, lit):
    client, camera = lit
    client.arm(plan_for(tmp_path / "d.mcap", "software", sequence=(STEPS[1], STEPS[0])))
    client.trigger()
    client.finish()
    path = tmp_path / "e.mcap"
    client.arm(plan_for(path, "Line1"))
    assert camera.trigger_line1()
    assert client.finish(1).complete
    assert int(next(read_frames([path])).picture[0, 0]) == 75  # 0.5 ms, the laser on


def test_recording_without_a_sequence_says_nothing_of_exposures(tmp_path, lit):
    client, _ = lit
    path = tmp_path / "c.mcap"
    client.arm(plan_for(path, "software"))
    client.trigger()
    assert client.finish().complete
    assert next(read_frames([path])).exposure is None
    assert EventKind.EXPOSED not in {event.kind for event in events(path)}


def test_lost_frame_ends_its_group_and_no_later_frame_takes_its_place(tmp_path):
    address, path = "127.20.5.2", tmp_path / "a.mcap"
    settings = sensor_at(address, laser_output="UserOutput0")
    faults = Faults(lost_frames=frozenset({1}))
    with (
        SimulatedCamera(address, Lamp(), faults=faults),
        capture_of(settings, tmp_path) as (client, _),
    ):
        wait_for(client, is_idle)
        client.arm(plan_for(path, "software", sequence=STEPS))
        with pytest.raises(CameraError, match="no frame came of the trigger"):
            client.trigger()
        client.trigger()
        report = client.finish()
    assert (report.triggered, report.recorded, report.lost) == (5, 4, 1)
    assert not report.complete
    seen = [(f.exposure.group, f.exposure.laser, int(f.picture[0, 0])) for f in read_frames([path])]
    assert seen == [(1, False, 100), (2, False, 100), (2, True, 150), (2, True, 60)]


class Camera:
    """Notes what it is told; rounds exposures to 10 us."""

    def __init__(self):
        self.told = []

    def trigger(self):
        self.told.append("trigger")

    def expose_as(self, step):
        made = ExposureStep(round(step.exposure_us, -1), step.gain_db, step.laser)
        self.told.append(made)
        return made


def test_what_is_recorded_is_what_the_camera_made_of_it():
    camera, sequencer = Camera(), Sequencer((ExposureStep(123.0, 1.0),))
    sequencer.begin()
    sequencer.fire(camera)
    assert camera.told == [ExposureStep(120.0, 1.0), "trigger"]
    assert sequencer.values_of(1)["exposure_us"] == 120.0
    assert sequencer.values_of(1) is None


def test_camera_that_numbers_anew_is_followed():
    camera, sequencer = Camera(), Sequencer((ExposureStep(100.0), ExposureStep(900.0)))
    sequencer.begin()
    sequencer.fire(camera)
    sequencer.fire(camera)
    sequencer.camera_started()
    sequencer.begin()
    sequencer.fire(camera)
    assert (sequencer.values_of(1)["group"], sequencer.triggered) == (2, 3)
    assert sequencer.values_of(2) is None  # its frame went with the camera


def test_without_a_sequence_a_command_takes_one_frame_as_the_camera_is():
    camera, sequencer = Camera(), Sequencer(())
    sequencer.begin()
    sequencer.fire(camera)
    assert (camera.told, sequencer.more, sequencer.values_of(1)) == (["trigger"], False, None)
