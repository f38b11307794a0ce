"""Shows what happens to files when a pass that was not armed is tried once more: those without a
frame make way, a frame is never touched.  Camera and worker are doubles."""

import pytest
from trackside import InProcess

from station.errors import CameraLost


@pytest.fixture
def ground(tmp_path, empty_store):
    ground = InProcess(tmp_path, empty_store)
    ground.captures["right"].reachable = False
    yield ground
    ground.close()


def put(ground):
    return ground.request("PUT", "/v1/passes/p1", json={}).status_code


def left_file(ground):
    return ground.layout.root / "recordings/passes/p1/left.mcap"


def test_a_file_without_a_frame_makes_way(ground):
    assert put(ground) == 503
    assert left_file(ground).exists()
    ground.captures["right"].reachable = True
    assert put(ground) == 201
    ground.captures["left"].wheel()
    reply = ground.request("POST", "/v1/passes/p1/finish", json={})
    found = {each["sensor"]: each["recorded"] for each in reply.json()["recordings"]}
    assert found == {"left": 1, "right": 0}


def test_a_frame_that_no_row_tells_of_is_not_touched(ground):
    assert put(ground) == 503
    left_file(ground).write_text("frame\n")
    ground.captures["right"].reachable = True
    assert put(ground) == 409
    assert left_file(ground).read_text() == "frame\n"
    assert put(ground) == 409  # and now its row tells of it
    assert ground.captures["right"].plan is None


def test_a_sensor_that_had_not_heard_of_the_failure_is_armed_with_the_others(ground):
    left = ground.captures["left"]
    left.finish = silent
    assert put(ground) == 503
    del left.finish
    ground.captures["right"].reachable = True
    assert left.plan is not None
    assert put(ground) == 201
    assert left.refused == []


def silent(_expected=None):
    raise CameraLost("the capture process does not answer")
