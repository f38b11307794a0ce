"""Does the bench of exposures compare with the truth?  Two poses, whose figures are no claims."""

import numpy as np
import pytest

from station.bench import bench_pairs
from station.bench.pairs import (
    TARGET,
    dot_errors_sigmas,
    observe_session,
    sheet_error_and_told_mm,
    true_centres_px,
)
from station.progress import silent
from station.scenes import paper_sensor

ALL = "long and short, laser on and off"


@pytest.fixture(scope="module")
def session():
    return observe_session(paper_sensor(), seed=1, poses=2)


def test_true_centres_are_the_means_of_the_discs_pictures(session):
    camera, pose = paper_sensor().camera, session[0].cam_from_board
    centre_px = true_centres_px(TARGET.points_mm[:1], pose, camera)
    # Points of a grid over the disc, each weighted by the area of picture it stands for.
    x, y = np.meshgrid(*2 * [np.linspace(-3.0, 3.0, 301)])
    inside = np.hypot(x, y) <= 3.0
    disc_mm = np.column_stack([x[inside], y[inside], np.zeros(inside.sum())])

    def seen(shift):
        return camera.project(pose.apply(disc_mm + shift))

    along = seen([1e-4, 0.0, 0.0]) - seen([-1e-4, 0.0, 0.0])
    across = seen([0.0, 1e-4, 0.0]) - seen([0.0, -1e-4, 0.0])
    area = np.abs(along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0])
    expected = np.average(seen(np.zeros(3)), axis=0, weights=area)
    # The grid's steps at the rim leave some 1e-4 px, a tenth of what the bench tells apart.
    np.testing.assert_allclose(centre_px[0], expected, atol=3e-4)


def test_dots_seen_in_all_exposures_are_off_the_truth_by_their_sigmas(session):
    good = session[0]
    errors = {
        name: dot_errors_sigmas(view.points, good.cam_from_board, paper_sensor().camera)
        for name, view in good.views.items()
    }
    assert list(errors)[-1] == ALL
    for off in errors.values():
        # The texture of one picture is one draw; a truth half a pixel aside were off by 100.
        assert 0.6 < np.sqrt(np.mean(off**2)) < 1.7


def test_all_shots_together_tell_the_dots_better_than_any(session):
    sigma = {name: np.median(view.points.sigma_px) for name, view in session[0].views.items()}
    assert sigma[ALL] < min(value for name, value in sigma.items() if name != ALL)


def test_session_that_determines_nothing_is_told_as_refused(session):
    views = [pose.views[ALL] for pose in session[:1]]
    assert np.isnan(sheet_error_and_told_mm(views, paper_sensor(), None)).all()


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_several_exposures_serve_a_solved_camera_at_least_as_well_as_one():
    rows = {row["exposures"]: row for row in bench_pairs(silent).rows}
    single = min(rows[name]["camera solved, mm"] for name in ("long", "short"))
    # Eight sessions of one or two effective degrees of freedom each tell a ratio to 25 %; the
    # sessions' poses and their targets' texture are common to all the rows, which helps.
    assert rows[ALL]["camera solved, mm"] < 1.1 * single
    assert rows[ALL]["camera known, mm"] < 1.1 * min(
        rows[name]["camera known, mm"] for name in ("long", "short")
    )
    assert 0.9 < rows[ALL]["dots' errors over sigma"] < 1.1
