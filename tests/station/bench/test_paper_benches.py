"""Do the paper's tables compare with the truth, and are their rows whole?"""

import cv2
import numpy as np
import pytest

from calib import Method, RigidTransform
from station.bench import bench_paper
from station.bench.deviations import _row, across_from_sheet_px, disc_centroids_px
from station.bench.paper_pictures import TARGET, see_targets
from station.progress import silent
from station.scenes import Light, TargetScene, paper_sensor

SENSOR = paper_sensor()


def scene():
    ray = SENSOR.locate(np.array([[1000.0, 500.0]]))[0]
    turn = RigidTransform.from_rotation_vector([0.4, 0.2, 0.1], np.zeros(3))
    middle = TARGET.points_mm.mean(axis=0)
    return TargetScene(SENSOR, TARGET, RigidTransform(turn.rotation, ray - turn.rotation @ middle))


def test_true_centroid_is_that_of_the_filled_outline():
    centre_mm = TARGET.points_mm[:1]
    (found,) = disc_centroids_px(scene(), centre_mm)
    angle = np.linspace(0.0, 2.0 * np.pi, 4000, endpoint=False)
    rim = centre_mm + 3.0 * np.column_stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)])
    outline = SENSOR.camera.project(scene().cam_from_board.apply(rim))
    about = outline - outline.mean(axis=0)
    moments = cv2.moments((about * 1.0).astype(np.float32))
    filled = outline.mean(axis=0) + [
        moments["m10"] / moments["m00"],
        moments["m01"] / moments["m00"],
    ]
    # Rings of equal area and single precision: 1e-4 px; the picture of the centre is 0.03 off.
    np.testing.assert_allclose(found, filled, atol=3e-4)


def test_distance_from_the_true_stripe_is_what_a_pixel_was_moved_by(rng):
    placed = scene()
    column = np.linspace(900.0, 1100.0, 20)
    row = np.full(20, 500.0)
    down = np.tile([0.0, 1.0], (20, 1))
    for _ in range(4):
        row -= across_from_sheet_px(placed, np.column_stack([column, row]), down)
    moved = rng.uniform(-1.0, 1.0, 20)
    off = across_from_sheet_px(placed, np.column_stack([column, row + moved]), down)
    # Perspective bends the distance by some 1e-4 of a pixel's step.
    np.testing.assert_allclose(off, moved, atol=1e-3)


def test_correction_brings_points_nearer_to_the_truth():
    seen = see_targets(SENSOR, (Light.DIM,), 4, [3])
    row = _row(Light.DIM, Method.JOINT, seen, SENSOR)
    assert row["dots after"] < row["dots before"] < 1.0
    assert row["stripe after"] < row["stripe before"] < 1.0


@pytest.mark.slow
def test_every_calibration_of_the_paper_has_a_row():
    table = bench_paper(silent, poses=4)
    names = [row["calibration"] for row in table.rows]
    assert names == [
        *(
            f"{name} ({method})"
            for name in ("CII", "CIIDC")
            for method in [*Method]
            if (method is Method.PREPLANAR) == (name == "CII")
        ),
        *(
            f"{name} ({method})"
            for name in ("CNII", "CNIIDC")
            for method in [*Method]
            if (method is Method.PREPLANAR) == (name == "CNII")
        ),
        "true sensor",
    ]
    for row in table.rows:
        assert row["distances, good"] < 0.1
