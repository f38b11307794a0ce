"""Is the demo's truth what its judgement takes it for?  No station runs here."""

from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest

from calib import Rig, RigidTransform
from station.demo.judgement import judge_rig, judge_wheels
from station.demo.scenario import AXLES, OFFSETS_MM, SHOWINGS, Scenario
from station.documents import Gate, RigDocument, RmsDocument, WheelDocument, sensors_of
from station.scenes import Light


@pytest.fixture(scope="module")
def scenario():
    return Scenario.draw(1)


@pytest.fixture(scope="module")
def truth(scenario):
    return scenario.rigs[0]


@pytest.fixture(scope="module")
def exact(truth):
    return truth.exact


def document_of(rig):
    return RigDocument(
        rig="left",
        side="left",
        created=datetime.now(UTC),
        software="test",
        method="boards",
        anchor=rig.names[0],
        sensors=sensors_of(rig, dict.fromkeys(rig.names, "none")),
        covariance=rig.covariance.tolist(),
        rms=RmsDocument(dots_px=0.1, stripe_px=0.1),
        quality={"showings_used": Gate(value=12, limit=3, passed=True)},
        options={},
        inputs=(),
    )


def test_true_rig_has_no_error_in_whatever_frame_it_stands(truth, exact):
    moved = exact.moved(RigidTransform.from_rotation_vector([0.1, -0.2, 0.3], [10.0, -20.0, 5.0]))
    for rig in (exact, moved):
        judged = judge_rig(truth, document_of(rig))
        assert judged.places_rms_mm < 1e-9
        assert judged.showings_used == 12


def test_sensor_that_is_placed_wrongly_to_the_other_is_seen(truth, exact):
    inner, outer = exact.sensors
    pose = outer.rig_from_camera
    shifted = RigidTransform(pose.rotation, pose.translation_mm + [0.0, 0.1, 0.0])
    rig = Rig((inner, replace(outer, rig_from_camera=shifted)), exact.covariance)
    # Shared out between two like fields, a shift of 0.1 mm leaves 0.05 at each, less what a turn
    # of both takes.
    assert 0.01 < judge_rig(truth, document_of(rig)).places_rms_mm < 0.05 + 1e-6


def test_every_sensor_sees_as_many_showings_in_the_same_lights_and_as_many_wheels(scenario):
    assert len(scenario.sensors) == 4
    for rig in scenario.rigs:
        assert len(rig.wheels) == AXLES
        lights = {tuple(scene.light for scene in sensor.poses) for sensor in rig.sensors}
        assert len(lights) == 1
        assert set(lights.pop()) == set(Light)
        for sensor in rig.sensors:
            assert len(sensor.poses) == SHOWINGS
            assert len(sensor.passes) == AXLES * len(OFFSETS_MM)


def test_sensors_of_a_rig_shake_by_themselves(truth):
    moved_mm = [
        np.array([scene.rig_from_camera.translation_mm for scene in sensor.passes])
        - sensor.rig_from_camera.translation_mm
        for sensor in truth.sensors
    ]
    apart_mm = moved_mm[0] - moved_mm[1]
    # Two times 0.3 mm in quadrature; 36 draws leave an eighth of it.
    assert 0.42 * 0.6 < apart_mm.std() < 0.42 * 1.4


def test_parts_of_a_profile_are_told_by_sensor(truth):
    d_mm = np.concatenate([np.arange(0.0, 25.0), np.arange(25.0, 90.0)])
    inner = (d_mm < 20.0) | (d_mm > 50.0)
    outer = d_mm > 5.0
    wheel = WheelDocument.model_validate({
        "source": "x",
        "sensor": "left",
        "profile": {
            "d_mm": d_mm.tolist(),
            "h_mm": [0.0] * len(d_mm),
            "sigma_mm": [0.01] * len(d_mm),
            "sensors": ["left-inner", "left-outer"],
            "seen_by": (inner + 2 * outer).tolist(),
        },
    })
    first, *others = judge_wheels(truth, {1: wheel})
    assert first.seen_mm == {
        "left-inner": [(0.0, 19.0), (51.0, 89.0)],
        "left-outer": [(6.0, 89.0)],
    }
    assert len(others) == AXLES - 1
    assert {other.reason for other in others} == {"no such wheel in the recordings"}
