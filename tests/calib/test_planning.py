"""Which picture to take next: that what is foretold of a picture is what it then brings.

Nothing here tells whether a person can hold a target so.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from synthetic_views import HEIGHT, PAPER_SENSOR, PAPER_TARGET, SIZE, setting

from calib import (
    PARAMETERS,
    Coverage,
    RigidTransform,
    Scatter,
    SheetDoubt,
    Standing,
    cramer_rao_bound,
    field_of,
    imagined_view,
    information_of,
    next_pose,
    pose_of,
    standing_of,
)

SCATTER = Scatter(0.05, 0.1)
DEPTHS_MM = (400.0, 800.0)
FREE = [PARAMETERS.index(name) for name in ("fx", "fy", "cx", "cy", "k1", "k2")]


@pytest.fixture
def field_px():
    return field_of(PAPER_SENSOR, DEPTHS_MM)


def _told(placed, views):
    return [
        information_of(view, placed.target, placed.sensor, pose)
        for view, pose in zip(views, placed.poses, strict=True)
    ]


@given(st.floats(0.5, 80.0), st.floats(-179.0, 179.0))
def test_a_target_stands_as_it_was_put(tilt_deg, near_deg):
    standing = Standing((10.0, -20.0, 600.0), tilt_deg, near_deg)
    found = standing_of(pose_of(standing, PAPER_TARGET), PAPER_TARGET)
    np.testing.assert_allclose(found.middle_in_cam_mm, standing.middle_in_cam_mm, atol=1e-9)
    assert found.tilt_deg == pytest.approx(tilt_deg, abs=1e-6)
    assert found.near_edge_deg == pytest.approx(near_deg, abs=1e-6)


@pytest.mark.parametrize(
    ("near_deg", "edge"), [(-90.0, (4, 0)), (90.0, (4, 9)), (0.0, (9, 4)), (180.0, (0, 4))]
)
def test_the_edge_that_is_named_is_the_nearest_to_the_camera(near_deg, edge):
    pose = pose_of(Standing((0.0, 0.0, 600.0), 30.0, near_deg), PAPER_TARGET)
    depth_mm = pose.apply(PAPER_TARGET.points_mm)[:, 2].reshape(10, 10)
    col, row = edge
    assert depth_mm[row, col] == pytest.approx(depth_mm.min(), abs=1e-9)


@pytest.mark.parametrize("tilt_deg", [-1.0, 90.0, float("nan")])
def test_a_tilt_that_shows_no_front_is_refused(tilt_deg):
    with pytest.raises(ValueError, match="0 up to 90"):
        Standing((0.0, 0.0, 600.0), tilt_deg)


def test_what_views_tell_adds_up_to_the_bound_of_all_together(rng):
    placed = setting(rng, 6)
    views = placed.views(rng, dots_px=0.1, stripe_px=0.2)
    bound = cramer_rao_bound(
        views, placed.target, placed.sensor, placed.poses, free_camera=tuple(FREE)
    )
    covariance = np.linalg.inv(np.sum(_told(placed, views), axis=0))
    np.testing.assert_allclose(covariance[:6, :6], bound[np.ix_(FREE, FREE)], rtol=1e-6)


def test_an_imagined_stripe_lies_on_sheet_and_board(field_px):
    middle = PAPER_SENSOR.locate(field_px[len(field_px) // 2][None])[0]
    pose = pose_of(Standing(tuple(middle.tolist()), 20.0, 40.0), PAPER_TARGET)
    view = imagined_view(PAPER_SENSOR, PAPER_TARGET, pose, SCATTER)
    on_board = pose.inverse().apply(PAPER_SENSOR.locate(view.stripe.centre_px))
    np.testing.assert_allclose(on_board[:, 2], 0.0, atol=1e-6)
    assert on_board[:, :2].min() > -1e-6
    assert on_board[:, :2].max() < 90.0 + 1e-6
    slope = np.diff(view.stripe.centre_px, axis=0)
    assert np.abs(np.einsum("ij,ij->i", slope, view.stripe.normal[1:])).max() < 0.01


@pytest.mark.parametrize(
    "standing",
    [
        Standing((400.0, 0.0, 600.0), 0.0),  # out of the picture
        Standing((0.0, 0.0, -600.0), 0.0),  # behind the camera
        Standing((0.0, 300.0, 2000.0), 0.0),  # far from the sheet
    ],
)
def test_a_target_that_would_not_be_seen_whole_and_crossed_is_not_imagined(standing):
    pose = pose_of(standing, PAPER_TARGET)
    assert imagined_view(PAPER_SENSOR, PAPER_TARGET, pose, SCATTER) is None


def test_the_pose_advised_brings_what_it_promises_and_more_than_another_like_the_last(
    rng, field_px
):
    placed = setting(rng, 3, tilt_rad=0.02)
    views = placed.views(rng, dots_px=0.05, stripe_px=0.1, stripe_count=60)
    doubt = SheetDoubt.of(PAPER_SENSOR, field_px, told := _told(placed, views))
    advised = next_pose(doubt, PAPER_TARGET, SCATTER)
    pose = pose_of(advised.standing, PAPER_TARGET)
    view = imagined_view(PAPER_SENSOR, PAPER_TARGET, pose, SCATTER)
    brought = information_of(view, PAPER_TARGET, PAPER_SENSOR, pose)
    then = SheetDoubt.of(PAPER_SENSOR, field_px, [*told, brought])
    assert then.sigma_mm() == pytest.approx(advised.sigma_mm, rel=1e-9)
    # Boards that all face the camera say little of it: another such one brings little.
    assert advised.standing.tilt_deg > 0.0
    assert advised.sigma_mm < 0.7 * doubt.sigma_mm(told[-1])


def test_advice_followed_from_the_first_picture_on_ends_below_random_poses(rng, field_px):
    told = []
    for _ in range(6):
        doubt = SheetDoubt.of(PAPER_SENSOR, field_px, told)
        pose = pose_of(next_pose(doubt, PAPER_TARGET, SCATTER).standing, PAPER_TARGET)
        view = imagined_view(PAPER_SENSOR, PAPER_TARGET, pose, SCATTER)
        told.append(information_of(view, PAPER_TARGET, PAPER_SENSOR, pose))
    placed = setting(rng, 6)
    by_chance = _told(placed, placed.views(rng, dots_px=0.05, stripe_px=0.1, stripe_count=60))
    advised_mm, chance_mm = (
        SheetDoubt.of(PAPER_SENSOR, field_px, each).sigma_mm() for each in (told, by_chance)
    )
    assert advised_mm < chance_mm


def test_cells_without_dots_come_first_where_coverage_is_wanted(field_px):
    top_only = field_px[field_px[:, 1] < HEIGHT / 2]
    coverage = Coverage.of(top_only, field_px, **SIZE)
    assert 0.0 < coverage.share < 1.0
    advised = next_pose(SheetDoubt.of(PAPER_SENSOR, field_px, []), PAPER_TARGET, SCATTER, coverage)
    assert advised.centre_px[1] > HEIGHT / 2


def test_coverage_counts_only_the_cells_in_which_the_sensor_measures():
    left = np.array([[10.0, 10.0], [20.0, 20.0]])
    coverage = Coverage.of(left, np.array([[15.0, 15.0], [2000.0, 1000.0]]), **SIZE)
    assert coverage.dots[0, 0] == 2
    assert coverage.share == 0.5
    assert np.argwhere(coverage.missing).tolist() == [[5, 7]]
    assert coverage.gain(np.array([[2000.0, 1000.0]]), **SIZE) == 1
    nowhere = Coverage.of(left, np.empty((0, 2)), **SIZE)
    assert nowhere.share == 0.0


def test_scatter_is_that_of_the_views_and_as_usual_without_any(rng):
    views = setting(rng, 2).views(rng, dots_px=0.3, stripe_px=0.6, stripe_count=60)
    found = Scatter.of(views)
    assert found.dot_px == pytest.approx(0.3)
    assert found.stripe_px == pytest.approx(0.6)
    assert Scatter.of([]).dot_px > 0.0
    with pytest.raises(ValueError, match="scatter"):
        Scatter(0.0, 1.0)


def test_a_field_between_depths_that_the_sheet_never_has_is_all_of_the_sheet():
    everything = field_of(PAPER_SENSOR, (0.0, 1e9))
    np.testing.assert_array_equal(field_of(PAPER_SENSOR, (1e9, 2e9)), everything)
    depth_mm = PAPER_SENSOR.locate(field_of(PAPER_SENSOR, DEPTHS_MM))[:, 2]
    assert depth_mm.min() >= DEPTHS_MM[0]
    assert depth_mm.max() <= DEPTHS_MM[1]


def test_a_pose_is_imagined_only_where_a_sheet_crosses_the_board_clearly():
    along = RigidTransform.from_rotation_vector([np.pi / 2.2, 0.0, 0.0], [-45.0, -180.0, 600.0])
    assert imagined_view(PAPER_SENSOR, PAPER_TARGET, along, SCATTER) is None
