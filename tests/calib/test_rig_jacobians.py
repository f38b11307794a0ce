"""The derivatives of a rig's solve against differences.  They say nothing of where it ends."""

from dataclasses import replace

import numpy as np
import pytest
from rig_scene import BOARD, board_errors, calibrated, drawn, placings, two_boards

from calib import RigidTransform, Target
from calib.solving.rig.belief import RigBelief, RigPlace
from calib.solving.rig.problem import Given, first_state
from calib.solving.rig.seen import seen_views
from calib.solving.rig.start import start_rig
from calib.solving.rig.turned import board_from_turned, numberings, turned_view
from calib.solving.rig.unknowns import FULL_LAYOUT, SensorPrior

_STEP = 1e-5
_DOTS_TRIED = (0, 17, 55, 56, 90, 111)


@pytest.fixture
def started(rng):
    """A problem, and a state some sigmas off its start, where nothing is at a minimum."""
    sensor = calibrated(rng)
    scene = two_boards({name: drawn(sensor, rng) for name in ("inner", "outer")})
    shifts = board_errors(rng, scene, 0.02)
    showings = [
        scene.showing(f"s{index}", pose, rng, shifts, stripe_count=20)
        for index, pose in enumerate(placings(rng, scene, 4))
    ]
    sensors = dict.fromkeys(scene.sensors, sensor)
    seen, _ = seen_views(showings, sensors, scene.boards)
    start = start_rig(seen, scene.boards, "outer")
    problem = Given(sensors, scene.boards, dict.fromkeys(scene.boards, 0.02), "outer").problem(
        start.views
    )
    step = rng.normal(size=problem.layout.size) * 1e-4
    shift = rng.normal(size=(len(problem.dot_sigma_mm), 3)) * 0.01
    return problem, problem.layout.moved(first_state(problem, start), step, shift)


def _residuals(problem, state):
    place = RigPlace.at(problem, state)
    parts = [part.residual.ravel() for each in place.channels for part in (each.dots, each.stripe)]
    parts += [*(-own for own in state.own)]
    parts.append((-state.dot_shift_mm / problem.dot_sigma_mm[:, None]).ravel())
    return np.concatenate(parts)


def _differences(problem, state, step, dots):
    ahead = _residuals(problem, problem.layout.moved(state, step * _STEP, dots * _STEP))
    behind = _residuals(problem, problem.layout.moved(state, -step * _STEP, -dots * _STEP))
    return -(ahead - behind) / (2.0 * _STEP)


def _unit_belief(problem, place):
    belief = RigBelief.from_medians(problem, place)
    one = replace(belief.dots[0], scale=1.0)
    return replace(
        belief,
        dots=(one,) * 2,
        stripe=(one,) * 2,
        dots_weight=tuple(np.ones_like(each) for each in belief.dots_weight),
        stripe_weight=tuple(np.ones_like(each) for each in belief.stripe_weight),
    )


def test_normal_equations_are_those_of_differences(started):
    problem, state = started
    size, dots = problem.layout.size, len(problem.dot_sigma_mm)
    place = RigPlace.at(problem, state)
    _, total = _unit_belief(problem, place).equations(problem, place)
    residual = _residuals(problem, state)
    none = np.zeros((dots, 3))
    by_step = np.column_stack([_differences(problem, state, each, none) for each in np.eye(size)])
    scale = np.sqrt(np.diag(total.shared))
    # Differences of step 1e-5 rad over slopes of 1e7 curve by 1e-4 of themselves; the disc's lens
    # shift, whose slope is left out, is 1e-4 as well.
    np.testing.assert_allclose(
        by_step.T @ by_step / np.outer(scale, scale),
        total.shared / np.outer(scale, scale),
        atol=2e-4,
    )
    length = np.linalg.norm(residual)
    np.testing.assert_allclose(
        by_step.T @ residual / scale, total.shared_side / scale, atol=2e-4 * length
    )
    for dot in _DOTS_TRIED:
        unit = np.zeros((3, dots, 3))
        unit[range(3), dot, range(3)] = 1.0
        by_dot = np.column_stack([
            _differences(problem, state, np.zeros(size), each) for each in unit
        ])
        np.testing.assert_allclose(by_dot.T @ by_dot, total.views[dot], rtol=2e-4, atol=1.0)
        own = np.sqrt(np.diag(total.views[dot]))
        np.testing.assert_allclose(
            by_dot.T @ by_step / np.outer(own, scale),
            total.border[dot] / np.outer(own, scale),
            atol=2e-4,
        )
        np.testing.assert_allclose(
            by_dot.T @ residual / own, total.views_side[dot] / own, atol=2e-4 * length
        )


def test_cost_is_half_the_sum_of_squares(started):
    problem, state = started
    place = RigPlace.at(problem, state)
    belief = _unit_belief(problem, place)
    squares = _residuals(problem, state) @ _residuals(problem, state)
    assert belief.cost(problem, place) == pytest.approx(squares / 2.0)
    assert belief.equations(problem, place)[1].cost == pytest.approx(squares / 2.0)


def test_prior_of_a_sensor_has_its_covariance_and_holds_what_is_held(rng):
    sensor = calibrated(rng)
    prior = SensorPrior.of(sensor)
    to_sensor = FULL_LAYOUT.sensor_from_global(prior.at(np.zeros(prior.size)))
    root = to_sensor @ prior.root
    scale = np.sqrt(np.diag(sensor.covariance)) + 1e-12
    np.testing.assert_allclose(
        root @ root.T / np.outer(scale, scale),
        sensor.covariance / np.outer(scale, scale),
        atol=1e-6,
    )
    # fx, fy, cx, cy, k1, k2 and the three of the plane are open.
    assert prior.size == 9


def test_own_parameters_move_the_sensor_as_their_derivative_says(rng):
    prior = SensorPrior.of(calibrated(rng))
    own = rng.normal(size=prior.size) * 30.0
    at, by_own = prior.at(own), prior.step_by_own(own)
    to_sensor = FULL_LAYOUT.sensor_from_global(at)
    for column, unit in enumerate(np.eye(prior.size)):
        ahead, behind = prior.at(own + 1e-3 * unit), prior.at(own - 1e-3 * unit)
        by_difference = (_thirteen(ahead) - _thirteen(behind)) / 2e-3
        expected = to_sensor @ by_own[:, column]
        np.testing.assert_allclose(by_difference, expected, rtol=1e-6, atol=1e-9)


def _thirteen(estimate):
    return np.concatenate([estimate.camera, estimate.normal, [estimate.offset_mm]])


@pytest.mark.parametrize("target", [BOARD, Target.parse("dots:6x6:10")])
def test_turned_numbering_is_a_turned_frame(target, rng):
    sensor = calibrated(rng)
    scene = two_boards({"inner": sensor, "outer": sensor})
    pose = placings(rng, scene, 1)[0] @ RigidTransform(np.eye(3), -target.points_mm.mean(axis=0))
    points = scene.showing("s", placings(rng, scene, 1)[0], rng, board_errors(rng, scene, 0.0))
    view = points.views["inner"][1]
    for quarters in numberings(target):
        turned = board_from_turned(target, quarters)
        # What is at a turned number is, numbered as the board, at the same place in space.
        numbers = np.array([[0, 1], [2, 3]])
        chosen = replace(
            view,
            points=replace(
                view.points,
                row=numbers[:, 0],
                col=numbers[:, 1],
                centre_px=view.points.centre_px[:2],
                sigma_px=view.points.sigma_px[:2],
                cause=view.points.cause[:2],
            ),
        )
        there = turned_view(chosen, target, quarters).points
        np.testing.assert_allclose(
            pose.apply(there.points_mm(target.pitch_mm)),
            (pose @ turned).apply(chosen.points.points_mm(target.pitch_mm)),
            atol=1e-9,
        )
