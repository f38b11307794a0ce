"""A look gives what the camera sees and leaves nothing behind; it never costs a recording a frame.

How long an arm waits behind a look is measured by hand: see the module of the look.
"""

import os
import threading

import cv2
import numpy as np
import pytest
from capture_rig import (
    HEIGHT,
    PICTURES,
    WIDTH,
    assert_served,
    capture_of,
    is_idle,
    plan_for,
    sensor_at,
    served_pictures,
    small_camera,
    wait_for,
)

from station.capture import CaptureState
from station.capture.looking import take_look
from station.capture.ring import Ring
from station.capture.sensor_capture import SensorCapture
from station.capture.stream import ReceivedFrame
from station.errors import CameraError, CameraLost, StateConflict
from station.viewing import Form, SharedPicture, Viewer, ViewOrder

ADDRESS = "127.42.1.1"


@pytest.fixture(scope="module")
def shared_sensor(tmp_path_factory):
    """Yield the client of a sensor, and its camera; both are slow to begin."""
    settings = sensor_at(ADDRESS)
    folder = tmp_path_factory.mktemp("run")
    with small_camera(ADDRESS) as camera, capture_of(settings, folder) as (client, _):
        yield client, camera


@pytest.fixture
def sensor(shared_sensor):
    """Return the client of an idle sensor, and its camera."""
    wait_for(shared_sensor[0], is_idle)
    return shared_sensor


def seen_by(client):
    with client.look() as look:
        assert (look.width, look.height) == (WIDTH, HEIGHT)
        content = os.pread(look.descriptor, WIDTH * HEIGHT, 0)
    return np.frombuffer(content, np.uint8).reshape(HEIGHT, WIDTH)


def test_a_look_is_what_the_camera_sees_and_is_recorded_nowhere(sensor, tmp_path):
    client, camera = sensor
    before = set(tmp_path.parent.rglob("*"))
    recorded, exposed = client.status().totals["recorded"], camera.statistics().exposed
    for exposure in range(exposed, exposed + 3):
        np.testing.assert_array_equal(seen_by(client), served_pictures()[exposure % PICTURES])
    assert client.status().state is CaptureState.IDLE
    assert client.status().totals["recorded"] == recorded
    assert set(tmp_path.parent.rglob("*")) == before
    assert camera.statistics().exposed == exposed + 3


def test_a_look_is_handed_on_to_who_makes_pictures_of_it(sensor, tmp_path):
    client, camera = sensor
    exposed = camera.statistics().exposed
    viewer = Viewer("info", tmp_path / "processes.lock")
    with client.look() as look:
        shared = SharedPicture(look.descriptor, look.width, look.height, look.received_ns)
        view = viewer.view(ViewOrder(Form.PNG, shared=shared))
    viewer.close()
    picture = cv2.imdecode(np.frombuffer(view.content, np.uint8), cv2.IMREAD_UNCHANGED)
    np.testing.assert_array_equal(picture, served_pictures()[exposed % PICTURES])
    assert view.frame.received_ns == look.received_ns


def test_only_an_idle_sensor_is_looked_through_and_its_recording_stays_whole(sensor, tmp_path):
    client, camera = sensor
    path = tmp_path / "a.mcap"
    client.arm(plan_for(path))
    exposed = camera.statistics().exposed
    for _ in range(4):
        assert camera.trigger_line1()
        with pytest.raises(StateConflict, match="is recording; `look` needs it to be idle") as seen:
            client.look()
        assert seen.value.state == "recording"
    report = client.finish(expected_frames=4)
    assert report.complete
    assert_served(path, exposed % PICTURES, range(1, 5))


def test_arms_that_come_while_somebody_looks_succeed_and_lose_nothing(sensor, tmp_path):
    client, camera = sensor
    ended, looked, refused = threading.Event(), [], []

    def look_again_and_again():
        while not ended.is_set():
            try:
                looked.append(client.look().close())
            except StateConflict as error:
                refused.append(error)

    onlookers = [threading.Thread(target=look_again_and_again) for _ in range(2)]
    for thread in onlookers:
        thread.start()
    try:
        for number in range(8):
            client.arm(plan_for(tmp_path / f"{number}.mcap"))
            exposed = camera.statistics().exposed
            assert camera.trigger_line1()
            assert camera.trigger_line1()
            assert client.finish(expected_frames=2).complete
            assert_served(tmp_path / f"{number}.mcap", exposed % PICTURES, (1, 2))
    finally:
        ended.set()
        for thread in onlookers:
            thread.join()
    assert looked
    assert refused


def test_a_camera_lost_while_it_is_looked_through_is_opened_again(sensor, tmp_path):
    client, camera = sensor
    camera.freeze()
    with pytest.raises((CameraError, StateConflict)):
        client.look()
    status = wait_for(client, lambda status: status.state is CaptureState.UNAVAILABLE)
    assert status.problem is not None
    camera.thaw()
    wait_for(client, is_idle)
    seen_by(client)
    client.arm(plan_for(tmp_path / "a.mcap"))
    assert camera.trigger_line1()
    assert client.finish(expected_frames=1).complete


@pytest.fixture
def ring():
    made = Ring.create(1, WIDTH * HEIGHT)
    yield made
    made.close()


class DummyStream:
    """Yields what came of a trigger, and notes how it was closed."""

    in_flight = False

    def __init__(self, *frames):
        self.frames, self.closed = frames, []

    def take(self, _timeout_us):
        return iter(self.frames)

    def close(self, *, lost):
        self.closed.append(lost)


class DummyCamera:
    """Gives one stream, and answers so often."""

    exposure_us = 100.0

    def __init__(self, stream, answers=9):
        self.stream, self.left, self.done = stream, answers, []

    def answers(self):
        self.left -= 1
        return self.left >= 0

    def start(self, trigger, _ring, _slots):
        self.done.append(trigger)
        return self.stream

    def trigger(self):
        self.done.append("exposed")

    def stop(self):
        self.done.append("stopped")


@pytest.mark.parametrize(
    ("frames", "says"),
    [
        ((), "no frame came of the trigger; look again"),
        ((ReceivedFrame(0, 1, 0, 0, 0, 0, "missing packets"),), "incomplete .missing packets.; lo"),
    ],
)
def test_a_picture_that_does_not_come_whole_is_said_and_the_camera_stopped(ring, frames, says):
    stream = DummyStream(*frames)
    camera = DummyCamera(stream)
    with pytest.raises(CameraError, match=says):
        take_look(camera, ring)
    assert camera.done == ["software", "exposed", "stopped"]
    assert stream.closed == [False]


def test_a_camera_that_falls_silent_after_the_trigger_is_given_no_more_orders(ring):
    stream = DummyStream()
    camera = DummyCamera(stream, answers=1)
    with pytest.raises(CameraLost, match="stopped answering"):
        take_look(camera, ring)
    assert camera.done == ["software", "exposed"]
    assert stream.closed == [True]


def test_a_silent_camera_is_given_no_order_at_all(ring):
    camera = DummyCamera(DummyStream(), answers=0)
    with pytest.raises(CameraLost, match="stopped answering"):
        take_look(camera, ring)
    assert camera.done == []


def test_a_camera_that_is_lost_is_let_go_of_at_once(monkeypatch):
    """One that comes back a moment later acquires still, for a stream that nobody reads."""
    capture = SensorCapture(sensor_at("127.42.1.9"))
    dropped = []
    monkeypatch.setattr(capture._keeper, "ensure_open", lambda: (DummyCamera(None, 0), None, None))
    monkeypatch.setattr(capture._keeper, "drop", dropped.append)
    with pytest.raises(CameraLost):
        capture.look()
    assert dropped == ["the camera stopped answering; check its power and cable"]
