"""From the end of a rig's solve to values: sensors and covariance, boards, pictures, fits."""

from collections.abc import Mapping

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray
from calib.camera import CameraModel
from calib.rig import RIG_PARAMETERS, Rig, RigSensor
from calib.sensor import SENSOR_PARAMETERS, LaserSensor
from calib.solving.assembly import solved_views
from calib.solving.prepared import PointsAnswer, rms_px
from calib.solving.rig.answer import SensorFit, SolvedBoard, SolvedRigView
from calib.solving.rig.problem import RigProblem
from calib.solving.rig.seen import SeenView
from calib.solving.rig.solve import RigSolution
from calib.solving.rig.unknowns import FULL_LAYOUT

# A stripe fewer of whose points are believed is not on the sheet as a whole.
_LEAST_STRIPE_BELIEVED = 0.5


def solved_rig(problem: RigProblem, solution: RigSolution) -> Rig:
    """Return the sensors with their joint covariance, in the frame of the anchor's camera."""
    state, layout = solution.place.state, problem.layout
    count = len(RIG_PARAMETERS)
    jacobian = np.zeros((count * len(problem.sensors), layout.size))
    for index, prior in enumerate(problem.priors):
        to_sensor = FULL_LAYOUT.sensor_from_global(prior.at(state.own[index]))
        rows = slice(count * index, count * index + len(SENSOR_PARAMETERS))
        jacobian[rows, layout.own(index)] = to_sensor @ prior.step_by_own(state.own[index])
        pose = layout.camera(index)
        jacobian[rows.stop : count * (index + 1), pose] = np.eye(6)[:, : pose.stop - pose.start]
    covariance = jacobian @ solution.covariance.shared @ jacobian.T
    sensors = tuple(
        RigSensor(
            name,
            _sensor(problem, solution, index, covariance[count * index :, count * index :]),
            state.cameras[index],
        )
        for index, name in enumerate(problem.sensors)
    )
    return Rig(sensors, (covariance + covariance.T) / 2.0)


def _sensor(
    problem: RigProblem, solution: RigSolution, index: int, covariance: FloatArray
) -> LaserSensor:
    prior = problem.priors[index]
    at, like = prior.at(solution.place.state.own[index]), prior.sensor.camera
    own = covariance[: len(SENSOR_PARAMETERS), : len(SENSOR_PARAMETERS)]
    camera = CameraModel.from_parameters(
        at.camera, width=like.width, height=like.height, covariance=own[:9, :9]
    )
    return LaserSensor(camera, at.plane, own)


def solved_boards(
    problem: RigProblem, solution: RigSolution, sigma_mm: Mapping[str, float]
) -> tuple[SolvedBoard, ...]:
    """Return where the boards stand, and how far their points are off their places."""
    state, shared = solution.place.state, solution.covariance.shared
    edges = _edges_of_boards(problem)
    boards = []
    for index, name in enumerate(problem.boards):
        dots, pose = slice(edges[index], edges[index + 1]), problem.layout.board(index)
        covariance = np.zeros((6, 6))
        if index:
            covariance = shared[pose, pose]
        found = _found_sigma(
            state.dot_shift_mm[dots], solution.covariance.views[dots], problem.dot_sigma_mm[dots]
        )
        boards.append(
            SolvedBoard(
                name=name,
                target_from_board=state.boards[index],
                covariance=covariance,
                dot_shift_mm=state.dot_shift_mm[dots],
                sigma_mm=sigma_mm[name],
                found_sigma_mm=found,
            )
        )
    return tuple(boards)


def _edges_of_boards(problem: RigProblem) -> list[int]:
    """Return where the dots of each board begin, and where the last ends."""
    return [*problem.first_dot, len(problem.dot_sigma_mm)]


def _found_sigma(shift_mm: FloatArray, covariance: FloatArray, sigma_mm: FloatArray) -> float:
    r"""Return how far points are off, from shifts that were drawn towards none.

    Of the expected square :math:`\sigma^2`, a posterior of variance v shows
    :math:`\sigma^2 - v`.
    """
    left = np.einsum("dii->di", covariance)
    shown = np.maximum(sigma_mm[:, None] ** 2 - left, 0.0).sum()
    if not shown > 0.0:
        return float(sigma_mm.mean())
    return float(sigma_mm.mean() * np.sqrt((shift_mm**2).sum() / shown))


def solved_pictures(
    problem: RigProblem, solution: RigSolution, seen: Mapping[tuple[str, str], SeenView]
) -> dict[tuple[str, str], SolvedRigView]:
    """Return the pictures that took part, by showing and sensor."""
    found = {}
    for index, channel in enumerate(problem.channels):
        dots, stripe, false = _points(problem, solution, index)
        poses = solution.place.channels[index].estimate.poses
        count = channel.observations.count
        solved = solved_views(channel.views, range(count), {}, poses, dots, stripe, false)
        name, board = problem.sensors[channel.sensor], problem.boards[channel.board]
        for view, showing in zip(solved, channel.showing, strict=True):
            key = (problem.showings[showing], name)
            own = seen[key]
            found[key] = SolvedRigView(key[0], name, board, own.quarters, view, own.view)
    return found


def fits_of(problem: RigProblem, solution: RigSolution) -> dict[str, SensorFit]:
    """Return how the pictures of each sensor fit."""
    pictures = np.bincount(np.concatenate([each.showing for each in problem.channels]))
    fits = {}
    for sensor, name in enumerate(problem.sensors):
        own = problem.of_sensor(sensor)
        points = [_points(problem, solution, index) for index in own]
        showings = np.concatenate([problem.channels[index].showing for index in own])
        dots, stripe = solution.belief.dots[sensor], solution.belief.stripe[sensor]
        lit = any(problem.channels[index].stripe_in.any() for index in own)
        fits[name] = SensorFit(
            views=len(showings),
            paired=int((pictures[showings] > 1).sum()),
            rms_dots_px=rms_px([each[0] for each in points]),
            rms_stripe_px=rms_px([each[1] for each in points]),
            sigma_scale_dots=dots.scale,
            sigma_scale_stripe=stripe.scale if lit else 0.0,
            outlier_fraction_dots=dots.share,
            outlier_fraction_stripe=stripe.share if lit else 0.0,
        )
    return fits


def all_points(
    problem: RigProblem, solution: RigSolution
) -> tuple[list[PointsAnswer], list[PointsAnswer]]:
    """Return what became of the dots and of the stripe points of all channels."""
    points = [_points(problem, solution, index) for index in range(len(problem.channels))]
    return [each[0] for each in points], [each[1] for each in points]


def _points(
    problem: RigProblem, solution: RigSolution, index: int
) -> tuple[PointsAnswer, PointsAnswer, frozenset[int]]:
    """Return what became of a channel's dots and stripe points, and its false stripes."""
    channel, at = problem.channels[index], solution.place.channels[index]
    seen, belief = channel.observations, solution.belief
    stripe_used = channel.stripe_in & belief.stripe[channel.sensor].believed(at.stripe.residual)
    false = _false_stripes(channel.observations.stripe.view, stripe_used, seen.count)
    stripe_used &= ~np.isin(seen.stripe.view, sorted(false))
    return (
        PointsAnswer(
            corrected_px=at.dots.model_px,
            deviation_px=np.linalg.norm(seen.dots.seen_px - at.dots.model_px, axis=1),
            used=belief.dots[channel.sensor].believed(at.dots.residual),
        ),
        PointsAnswer(
            corrected_px=at.stripe.model_px,
            deviation_px=np.abs(at.stripe.residual[:, 0] * seen.stripe.sigma_px),
            used=stripe_used,
        ),
        false,
    )


def _false_stripes(view: IntArray, used: BoolArray, count: int) -> frozenset[int]:
    points = np.bincount(view, minlength=count)
    good = np.bincount(view, used, minlength=count)
    return frozenset(np.flatnonzero(good < _LEAST_STRIPE_BELIEVED * points).tolist())
