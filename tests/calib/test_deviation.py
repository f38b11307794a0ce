"""The paper's own method: a bounded deviation of every point, then the plane."""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_views import PAPER_CAMERA, PAPER_PLANE, PAPER_TARGET, SIZE, setting

from calib import CameraRole, Cause, Method, NotConverged, Termination, calibrate
from calib.homography import apply_homography
from calib.solving.deviation import relocation
from calib.solving.deviation.cross_ratios import cross_ratio, fours_of
from calib.solving.deviation.dot_terms import Blunt, dot_terms
from calib.solving.deviation.reach import SIGMAS_ALLOWED
from calib.solving.deviation.state import Frame
from calib.solving.deviation.stripe_terms import lines_on_boards, stripe_terms
from calib.solving.joint.parameters import Estimate
from calib.solving.prepared import Prepared

DEVIATION = {**SIZE, "camera": PAPER_CAMERA, "method": Method.DEVIATION}
TRUTH = PAPER_PLANE.coefficients


def solved(views, **options):
    return calibrate(views, PAPER_TARGET, **DEVIATION | options)


def test_exact_points_give_the_exact_plane_and_no_deviation(rng):
    found = solved(setting(rng, 4).views(rng, dots_px=0, stripe_px=0))
    np.testing.assert_allclose(found.sensor.plane.coefficients, TRUTH, atol=1e-5)
    assert found.rms_dots_px < 1e-5
    assert found.solve.termination is Termination.CONVERGED


def test_corrected_points_lie_where_a_rigid_board_and_the_plane_put_them(rng):
    views = setting(rng, 5).views(rng, dots_px=0.5, stripe_px=0.5)
    found = solved(views)
    for view, answer in zip(views, found.views, strict=True):
        board = answer.cam_from_board.apply(view.points.points_mm(PAPER_TARGET.pitch_mm))
        # The search leaves a hundredth of a sigma, here 0.005 px, times the pull of a point.
        np.testing.assert_allclose(answer.dots.corrected_px, PAPER_CAMERA.project(board), atol=1e-3)
        on_sheet = found.sensor.locate(answer.stripe.corrected_px)
        off_board = (on_sheet - answer.cam_from_board.translation_mm) @ (
            answer.cam_from_board.rotation[:, 2]
        )
        # 1e-3 px are less than 1e-3 mm at these distances, and the sheet is met at a slant.
        np.testing.assert_allclose(off_board, 0.0, atol=5e-3)


def test_no_deviation_exceeds_nine_sigma(rng):
    views = setting(rng, 4).views(rng, dots_px=0.3, stripe_px=0.3)
    # Just within reach of its pose by all dots, and so driven onto its bound.
    views[0] = with_dot_moved(views[0], 33, [2.6, 0.0])
    found = solved(views)
    largest = 0.0
    for view, answer in zip(views, found.views, strict=True):
        deviation = np.abs(view.points.centre_px - answer.dots.corrected_px)
        largest = max(largest, (deviation / view.points.sigma_px).max())
    assert 8.0 < largest <= SIGMAS_ALLOWED * 1.05


def with_dot_moved(view, dot, by_px):
    shift = np.zeros((len(view.points), 2))
    shift[dot] = by_px
    return replace(view, points=replace(view.points, centre_px=view.points.centre_px + shift))


def test_a_dot_that_nine_sigma_do_not_set_right_is_named_and_not_used(rng):
    views = setting(rng, 5).views(rng, dots_px=0.1, stripe_px=0.1)
    views[2] = with_dot_moved(views[2], 47, [0.0, 8.0])
    found = solved(views)
    assert not found.views[2].dots.used[47]
    assert found.views[2].dots.cause[47] is Cause.OUTLIER
    assert "view 2: dot at row 4, column 7" in found.solve.on_bound


def test_a_stripe_point_out_of_reach_of_its_line_takes_no_part(rng):
    views = setting(rng, 5).views(rng, dots_px=0.1, stripe_px=0.1)
    clean = solved(views).sensor.plane.coefficients
    centre = views[1].stripe.centre_px.copy()
    centre[4] += 30.0 * views[1].stripe.normal[4]
    views[1] = replace(views[1], stripe=replace(views[1].stripe, centre_px=centre))
    found = solved(views)
    assert not found.views[1].stripe.used[4]
    # One of 50 stripe points less: the plane moves by a part of its own uncertainty.
    sigma = np.sqrt(np.diag(found.sensor.covariance)[9:])
    assert (np.abs(found.sensor.plane.coefficients - clean) < sigma).all()


def test_stripes_that_lie_on_no_common_plane_are_refused_in_words():
    rng = np.random.default_rng(2)  # with others a plane is found that fits badly
    views = setting(rng, 4).views(rng, dots_px=0.1, stripe_px=0.1, stripe_count=10)
    exchanged = zip(views, [*views[1:], views[0]], strict=True)
    with pytest.raises(NotConverged, match="one light plane; look at the residuals"):
        solved([replace(view, stripe=other.stripe) for view, other in exchanged])


def test_predicted_uncertainty_is_true(rng):
    place = setting(rng, 6)
    squares = []
    for _ in range(12):
        found = solved(place.views(rng, dots_px=1.0, stripe_px=0.5))
        error = (found.sensor.plane.coefficients - TRUTH)[[0, 1, 3]]
        covariance = found.sensor.covariance[9:, 9:][np.ix_([0, 1, 3], [0, 1, 3])]
        squares.append(error @ np.linalg.solve(covariance, error))
    # Sum of 12 chi-squares of 3 degrees: mean 36, standard deviation 8.5; three of these allowed.
    assert 10.5 < sum(squares) < 61.5


def test_the_camera_s_doubt_is_in_the_covariance_of_the_plane(rng):
    views = setting(rng, 4).views(rng, dots_px=0.1, stripe_px=0.1)
    doubt = np.zeros((9, 9))
    doubt[0, 0] = 2.0**2
    doubtful = solved(views, camera=replace(PAPER_CAMERA, covariance=doubt))
    ends = [
        solved(views, camera=replace(PAPER_CAMERA, fx=PAPER_CAMERA.fx + step)).sensor.plane
        for step in (-2.0, 2.0)
    ]
    shift = (ends[1].offset_mm - ends[0].offset_mm) / 2.0
    added = doubtful.sensor.covariance[12, 12] - solved(views).sensor.covariance[12, 12]
    # 2 px are 1e-3 of fx, the curvature over that is smaller still; the weights of the points
    # follow the camera and make some percent.
    np.testing.assert_allclose(added, shift**2, rtol=0.1)


def test_a_search_cut_short_says_so(rng, monkeypatch):
    monkeypatch.setattr(relocation, "_MOST_STEPS", 1)
    found = solved(setting(rng, 3).views(rng, dots_px=2.0, stripe_px=2.0))
    assert found.solve.termination is Termination.STEP_LIMIT
    assert any("still moved after 4 steps" in warning for warning in found.warnings)


def test_cross_ratios_are_the_same_in_any_picture_of_a_line(rng):
    line = np.array([0.0, 1.0, 2.5, 4.0])[None, :, None] * [0.6, 0.8]
    homography = np.array([[1.0, 0.2, 3.0], [-0.1, 0.9, 1.0], [0.01, 0.02, 1.0]])
    seen = apply_homography(homography, line[0])[None]
    np.testing.assert_allclose(cross_ratio(seen)[0], cross_ratio(line)[0], rtol=1e-12)


def test_fours_reach_from_end_to_end_of_every_row_and_column(rng):
    views = setting(rng, 2).views(rng, dots_px=0, stripe_px=0)
    dots = prepared(views).observations.dots
    fours = fours_of(dots)
    assert len(fours) == 2 * (10 + 10)
    ends = dots.board_mm[fours[:, 3], :2] - dots.board_mm[fours[:, 0], :2]
    np.testing.assert_allclose(ends.sum(axis=1), 90.0)


def prepared(views):
    return Prepared.of(views, PAPER_TARGET, PAPER_CAMERA, CameraRole.HELD)


@pytest.mark.parametrize("along_rows", [True, False])
def test_derivatives_of_all_distances_are_those_by_differences(rng, along_rows):
    views = setting(rng, 3).views(rng, dots_px=1.0, stripe_px=1.0)
    # Views of unlike numbers of dots: their sums are padded.
    points = views[1].points
    views[1] = replace(
        views[1],
        points=replace(
            points,
            row=points.row[:64],
            col=points.col[:64],
            centre_px=points.centre_px[:64],
            sigma_px=points.sigma_px[:64],
            cause=points.cause[:64],
        ),
    )
    ready = prepared(views)
    frame = Frame(ready.observations, PAPER_CAMERA, np.full(3, along_rows))
    state = frame.started(Estimate.start(PAPER_CAMERA, ready.plane, list(ready.poses)))
    state = replace(state, lines=lines_on_boards(frame, state))
    fours, blunt = fours_of(ready.observations.dots), Blunt(0.01, 0.01, 1e-4)
    unbounded = np.full(frame.stripe_columns.max() + 1, np.inf)
    size = np.full(frame.size, 1e-3)
    size[np.concatenate([frame.pose_columns[:, :3].ravel(), frame.plane_columns[:2]])] = 1e-6
    size[frame.line_columns[:, 1]] = 1e-6
    step = size * rng.normal(size=frame.size)

    def terms(sign):
        at = frame.moved(state, sign * step, unbounded)
        return [*dot_terms(frame, at, fours, blunt), *stripe_terms(frame, at, 0.01)]

    before, here, after = terms(-1.0), terms(0.0), terms(1.0)
    assert len(here) == 7
    for one, term, other in zip(before, here, after, strict=True):
        length = np.maximum(np.linalg.norm(term.difference, axis=1), term.blunt)
        rise = (other.difference - one.difference) / 2.0 / np.sqrt(length)[:, None]
        # Central differences err by the cube of the step, 1e-9 of its length.
        np.testing.assert_allclose(
            term.rows(frame.size)[0] @ step, rise.ravel(), atol=1e-6 * np.abs(rise).max()
        )
