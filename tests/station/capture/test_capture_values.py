"""Plans, reports, the ring: small values that processes hand to one another."""

import json
from pathlib import Path

import numpy as np
import pytest

from station.capture import (
    CaptureReport,
    CaptureState,
    CaptureStatus,
    ExposureStep,
    RecordingPlan,
    Trigger,
)
from station.capture.ring import Ring
from station.recording import Event, EventKind

PATH = Path("/data/a.mcap")


def report(**changes):
    values = {
        "path": PATH,
        "triggered": 8,
        "recorded": 8,
        "lost": 0,
        "refused": 0,
        "repeated": 0,
        "resent_packets": 3,
        "first_time_ns": 1,
        "last_time_ns": 2,
        "events": (Event(EventKind.STARTED, 1, "x"),),
    }
    return CaptureReport(**{**values, **changes})


def through_json(value):
    return type(value).from_json(json.loads(json.dumps(value.to_json())))


def test_plan_survives_the_way_to_another_process():
    plan = RecordingPlan(
        "x", PATH, "left", Trigger.FREE, 5, 2.5, {"a": "b"}, {"calibration.json": b"\0\xff"}
    )
    assert through_json(plan) == plan


def test_plan_with_a_sequence_survives_the_way_to_another_process():
    steps = (ExposureStep(100.0, 3.0, laser=False), ExposureStep(900.0))
    plan = RecordingPlan("x", PATH, "left", Trigger.SOFTWARE, sequence=steps)
    assert through_json(plan) == plan


def test_sequence_without_software_trigger_is_refused():
    with pytest.raises(ValueError, match="trigger `software`"):
        RecordingPlan("x", PATH, "left", Trigger.LINE1, sequence=(ExposureStep(100.0),))


@pytest.mark.parametrize("wrong", [{"frames": 0}, {"seconds": float("nan")}, {"trigger": "Line9"}])
def test_plan_that_cannot_be_carried_out_is_refused(wrong):
    with pytest.raises(ValueError, match="must be|is not a valid"):
        RecordingPlan("x", PATH, "left", **wrong)


def test_path_of_a_plan_holds_in_another_process_too():
    assert RecordingPlan("x", Path("a.mcap"), "left").path == Path.cwd() / "a.mcap"


def test_report_survives_the_way_from_another_process():
    assert through_json(report()) == report()


def test_status_survives_the_way_from_another_process():
    status = CaptureStatus(CaptureState.BLIND, "left", "gone", {"a": "b"}, "x", PATH, 1, 2, 3, 4)
    assert through_json(status) == status


@pytest.mark.parametrize(
    ("changes", "complete"),
    [
        ({}, True),
        ({"triggered": None}, True),
        ({"triggered": 9}, False),
        ({"lost": 1, "triggered": None}, False),
        ({"refused": 1, "triggered": None}, False),
        ({"repeated": 2}, True),
        ({"events": (Event(EventKind.CAMERA_LOST, 1),)}, False),
        ({"events": (Event(EventKind.FRAMES_MISCOUNTED, 1),)}, False),
        ({"events": (Event(EventKind.RECORDER_RESTARTED, 1),)}, True),
    ],
)
def test_report_is_complete_only_where_every_frame_is_explained(changes, complete):
    assert report(**changes).complete is complete


def test_summary_is_one_line_of_account():
    line = report(triggered=10, lost=1, refused=1).summary()
    assert line == (
        "/data/a.mcap: 8 frames of 10 triggered recorded, 1 lost, 1 refused, 3 packets resent; "
        "not complete"
    )


def test_what_one_process_puts_into_the_ring_another_sees():
    ring = Ring.create(3, 5000)
    other = Ring(ring.descriptor, 5000)
    ring.picture(2, 5000)[:] = bytes(range(250)) * 20
    assert other.slots == 3
    assert bytes(other.picture(2, 5000)) == bytes(range(250)) * 20
    assert not any(other.picture(1, 5000))
    seen = np.ctypeslib.as_array((np.ctypeslib.ctypes.c_uint8 * 5).from_address(ring.address(2)))
    assert seen.tolist() == [0, 1, 2, 3, 4]
    ring.close()
