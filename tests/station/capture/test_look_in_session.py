"""Between the pictures of a calibration session the camera is looked through: that is recorded
nowhere, and costs the recording no frame, no number and no account."""

import os
import time

import numpy as np
import pytest
from capture_rig import (
    HEIGHT,
    PATIENCE_S,
    PICTURES,
    WIDTH,
    capture_of,
    is_idle,
    plan_for,
    sensor_at,
    served_pictures,
    small_camera,
    wait_for,
)

from station.capture import CaptureState, ExposureStep, RecordingPlan
from station.errors import CameraError, StateConflict
from station.pipeline import read_frames
from station.recording import frames, verify

ADDRESS = "127.76.1.1"
HEARTBEAT_MS = 1500


@pytest.fixture(scope="module")
def shared_sensor(tmp_path_factory):
    """Yield the client of a sensor, and its camera; both are slow to begin."""
    settings = sensor_at(ADDRESS, features={"GevHeartbeatTimeout": HEARTBEAT_MS})
    folder = tmp_path_factory.mktemp("run")
    with small_camera(ADDRESS) as camera, capture_of(settings, folder) as (client, _):
        yield client, camera


@pytest.fixture
def sensor(shared_sensor):
    """Return the client of an idle sensor, and its camera."""
    wait_for(shared_sensor[0], is_idle)
    return shared_sensor


def session_plan(path, **arguments):
    return plan_for(path, "software", looks=True, **arguments)


def seen_by(client):
    with looked(client) as look:
        content = os.pread(look.descriptor, WIDTH * HEIGHT, 0)
    return np.frombuffer(content, np.uint8).reshape(HEIGHT, WIDTH)


def looked(client):
    """Look, and again as whoever is refused is told to while a frame is still being written."""
    deadline_s = time.monotonic() + PATIENCE_S
    while True:
        try:
            return client.look()
        except StateConflict as error:
            if "look again" not in str(error) or time.monotonic() > deadline_s:
                raise


def served(exposure):
    return served_pictures()[exposure % PICTURES]


def test_looks_between_pictures_leave_the_recording_whole(sensor, tmp_path):
    client, camera = sensor
    path = tmp_path / "a.mcap"
    client.arm(session_plan(path))
    exposed, numbers, taken = camera.statistics().exposed, [], []
    for looks in (2, 0, 1, 3):
        for _ in range(looks):
            np.testing.assert_array_equal(seen_by(client), served(exposed))
            exposed += 1
        numbers.append(client.trigger())
        taken.append(served(exposed))
        exposed += 1
    np.testing.assert_array_equal(seen_by(client), served(exposed))
    assert client.status().state is CaptureState.RECORDING
    report = client.finish()
    assert (report.triggered, report.recorded, report.lost, report.complete) == (4, 4, 0, True)
    assert camera.statistics().exposed == exposed + 1
    assert numbers == [1, 2, 3, 4]
    recorded = list(frames(path))
    assert [frame.frame_id for frame in recorded] == numbers
    for frame, picture in zip(recorded, taken, strict=True):
        np.testing.assert_array_equal(frame.picture, picture)
    assert verify(path).ok


def test_frames_of_a_sequence_say_how_they_were_taken_behind_a_look(sensor, tmp_path):
    client, _ = sensor
    steps = (ExposureStep(1000.0, 0.0), ExposureStep(200.0, 0.0))
    client.arm(session_plan(tmp_path / "b.mcap", sequence=steps))
    assert client.trigger() == 2
    seen_by(client)
    assert client.trigger() == 4
    assert client.finish().complete
    told = [each.exposure for each in read_frames([tmp_path / "b.mcap"])]
    assert [(each.exposure_us, each.group) for each in told] == [
        (1000.0, 1),
        (200.0, 1),
        (1000.0, 2),
        (200.0, 2),
    ]


def test_a_recording_of_wheels_is_not_looked_into_though_it_is_triggered_by_command(
    sensor, tmp_path
):
    client, _ = sensor
    client.arm(plan_for(tmp_path / "c.mcap", "software"))
    with pytest.raises(StateConflict, match="needs it to be idle, or in a calibration") as seen:
        client.look()
    assert seen.value.state == "recording"
    assert client.trigger() == 1
    assert client.finish().complete
    with pytest.raises(ValueError, match="need the trigger `software`"):
        RecordingPlan("p", tmp_path / "d.mcap", "left", "Line1", looks=True)


def test_a_camera_lost_while_a_session_looks_comes_back_to_the_same_recording(sensor, tmp_path):
    client, camera = sensor
    client.arm(session_plan(tmp_path / "e.mcap"))
    assert client.trigger() == 1
    seen_by(client)
    camera.freeze()
    with pytest.raises((CameraError, StateConflict)):
        client.look()
    wait_for(client, lambda status: status.state is CaptureState.BLIND)
    camera.thaw()
    wait_for(client, lambda status: status.state is CaptureState.RECORDING)
    seen_by(client)
    assert client.trigger() == 2
    assert client.finish().recorded == 2
    assert [frame.frame_id for frame in frames(tmp_path / "e.mcap")] == [1, 2]
