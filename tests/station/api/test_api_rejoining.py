"""Shows when a sensor that stands idle beside a pass is armed again, and when it is left alone.

Camera and worker are doubles; that a killed process comes back so is shown in tests/station/serve.
"""

import json

import pytest
from trackside import InProcess, files_of

from station.capture import Interruption
from station.operations.closing import Closed
from station.operations.salvage import salvage_recording
from station.recording import RotatingWriter, Rotation
from station.store import EndedBy, Pass, the


@pytest.fixture
def ground(tmp_path, empty_store):
    ground = InProcess(tmp_path, empty_store)
    assert ground.request("PUT", "/v1/passes/p1", json={}).status_code == 201
    yield ground
    ground.close()


def file_of_left(ground):
    return ground.layout.root / "recordings/passes/p1/left.mcap"


def finish(ground, axles):
    body = ground.request("POST", "/v1/passes/p1/finish", json={"axles": axles}).json()
    return {each["sensor"]: each for each in body["recordings"]}


def test_what_was_recorded_before_and_after_is_one_recording(ground):
    left = ground.captures["left"]
    left.wheel()
    left.die()
    left.wheel()  # nobody is there
    ground.look()
    left.wheel()
    ground.captures["right"].wheel()
    found = finish(ground, 3)
    assert (found["left"]["recorded"], found["left"]["lost"], found["left"]["files"]) == (2, 1, 2)
    assert (found["left"]["recovered"], found["left"]["complete"]) == (True, False)
    assert "gone on with after the capture process died" in found["left"]["summary"]
    assert (found["right"]["recovered"], found["right"]["files"]) == (False, 1)
    told = ground.request("GET", "/v1/audit", params={"subject": "p1"}).json()["entries"]
    assert [(each["who"], each["action"]) for each in told][1] == ("station", "arm")
    assert told[1]["after"] == {"sensor": "left", "file": 2, "behind_frame": 1}


@pytest.mark.parametrize("begin_anew", [False, True])
def test_a_sensor_that_dies_again_and_again_is_left_out_and_that_is_said(ground, capfd, begin_anew):
    for _ in range(6):
        ground.captures["left"].die()
        if begin_anew:
            ground.begin()  # another API process counts by what is there
        ground.look()
    assert ground.captures["left"].plan is None
    assert len(files_of(file_of_left(ground))) == 4
    said = [line for line in capfd.readouterr().err.splitlines() if "left out of the pass" in line]
    assert json.loads(said[0])["sensor"] == "left"
    assert finish(ground, 2)["left"]["lost"] == 2


def test_nothing_is_armed_for_a_pass_whose_end_is_written(ground):
    left = ground.captures["left"]
    left.die()
    with ground.store.change() as session:
        the(session, Pass, "p1").ended_by = EndedBy.CONTROLLER
    statuses = {sensor: capture.status() for sensor, capture in ground.captures.items()}
    ground.app.state.parts.passes.rejoin("p1", statuses)
    assert left.plan is None


def test_a_sensor_without_its_camera_is_waited_for(ground):
    left = ground.captures["left"]
    left.die()
    left.reachable = False
    for _ in range(5):
        ground.look()
    left.reachable = True
    ground.look()
    assert left.plan is not None


def test_a_report_that_came_to_nobody_tells_of_the_interruption_too(tmp_path, recorded_twice):
    found = salvage_recording(recorded_twice)
    assert (found.frames, found.interruptions, found.last_frame_id) == (2, 1, 2)
    closed = Closed.from_salvage(found, 3, "no answer")
    assert (closed.recorded, closed.lost, closed.recovered, closed.files) == (2, 1, True, 2)


@pytest.fixture
def recorded_twice(tmp_path):
    """A recording whose first writer did not live to tell where it goes on."""
    path = tmp_path / "left.mcap"
    picture = memoryview(bytes(16))
    said = {"triggered": "None", "lost": "0", "repeated": "0", "refused": "0", "complete": "False"}
    for before, accounting in ((0, None), (1, said | {"recorded": "2"})):
        metadata = {"session": {"id": "p1"}}
        writer = RotatingWriter(
            path, "left", rotation=Rotation(), metadata=metadata, files_before=before
        )
        writer.write_frame(before + 1, 1, 1, picture, 4, 4)
        writer.finish(accounting)
    return path


def test_an_interruption_goes_to_the_capture_process_as_it_is():
    before = Interruption(files=2, frames=7, last_frame_id=9, since_ns=5)
    assert Interruption.from_json(json.loads(json.dumps(before.to_json()))) == before
