"""Shows what becomes of an order to arm that comes while a camera obeys a capture process that was
killed.  The camera is left out, but for one slow test: it frees itself after 3 s."""

import pytest
from capture_rig import capture_of, is_idle, plan_for, sensor_at, small_camera, wait_for

from station.capture import sensor_capture
from station.capture.camera import ControlHeld
from station.capture.sensor_capture import SensorCapture
from station.errors import CameraRefused, CameraUnreachable, StateConflict


class HeldKeeper:
    """A camera that is not to be opened so many times."""

    def __init__(self, *refusals):
        self.refusals = list(refusals)
        self.camera = None
        self.problem = None

    def ensure_open(self):
        if self.refusals:
            raise self.refusals.pop(0)
        return "camera", "ring", "link"

    def is_due(self):
        return True

    def is_check_due(self, heard_s):
        return False

    def drop(self, problem):
        self.problem = problem


class Clock:
    def __init__(self):
        self.now_s = 100.0

    def monotonic(self):
        return self.now_s


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(sensor_capture, "time", clock)
    return clock


@pytest.fixture
def capture_with(clock, monkeypatch):
    def make(*refusals):
        capture = SensorCapture(sensor_at("127.0.0.9"))
        capture._keeper = HeldKeeper(*refusals)
        begun = []
        monkeypatch.setattr(capture, "_watch_camera", lambda: None)

        def begin(plan):
            capture._keeper.ensure_open()
            begun.append(plan)

        monkeypatch.setattr(capture, "_begin", begin)
        return capture, begun

    return make


HELD = ControlHeld("camera 127.0.0.9 is controlled by another program; end that first")


def test_arming_waits_for_the_camera_of_a_killed_capture_process(capture_with, tmp_path):
    capture, begun = capture_with(HELD, HELD)
    answers, plan = [], plan_for(tmp_path / "a.mcap")
    capture.arm(plan, answers.append)
    capture.step()
    assert (answers, begun) == ([], [])
    with pytest.raises(StateConflict, match="being armed already"):
        capture.arm(plan, answers.append)
    capture.step()
    assert (answers, begun) == ([{}], [plan])
    capture.step()
    assert len(answers) == 1


def test_camera_that_another_program_holds_is_refused_once_a_killed_one_would_have_lost_it(
    capture_with, clock, tmp_path
):
    capture, begun = capture_with(*[HELD] * 9)
    answers = []
    capture.arm(plan_for(tmp_path / "a.mcap"), answers.append)
    clock.now_s += 4.1
    capture.step()
    assert [answer["error"] for answer in answers] == ["CameraRefused"]
    with pytest.raises(CameraRefused, match="controlled by another program"):
        capture.arm(plan_for(tmp_path / "a.mcap"), answers.append)
    assert begun == []


def test_camera_that_cannot_be_opened_for_another_reason_is_refused_at_once(capture_with, tmp_path):
    capture, _ = capture_with(CameraUnreachable("no camera answers"))
    with pytest.raises(CameraUnreachable):
        capture.arm(plan_for(tmp_path / "a.mcap"), print)


@pytest.mark.slow
def test_sensor_is_armed_as_soon_as_its_camera_is_free_of_a_killed_capture_process(tmp_path):
    address = "127.33.3.1"
    with small_camera(address) as camera:
        with capture_of(sensor_at(address), tmp_path) as (client, process):
            wait_for(client, is_idle)
            process.kill()
            process.join()
        with capture_of(sensor_at(address), tmp_path) as (client, _):
            client.arm(plan_for(tmp_path / "a.mcap"))
            for _ in range(3):
                assert camera.trigger_line1()
            assert client.finish(expected_frames=3).complete
