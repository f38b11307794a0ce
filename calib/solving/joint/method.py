"""Method `joint`: poses, light plane and as wanted the camera, most likely all together."""

from dataclasses import replace

import numpy as np

from calib.arrays import FloatArray
from calib.calibration import CameraRole, SolveReport, Termination
from calib.camera import PARAMETERS, CameraModel
from calib.solving.joint.false_stripes import believable_stripes
from calib.solving.joint.parameters import Estimate, Layout
from calib.solving.joint.problem import Prior, Problem, Solution
from calib.solving.joint.second_look import acquitted
from calib.solving.joint.solve import solve
from calib.solving.prepared import Answer, PointsAnswer, Prepared

# Renewals of the choice which stripes to believe; more than two are not seen to change anything.
_ROUNDS = 4
# A scatter this many times the predicted one, or its inverse, is worth telling.
_SCALE_WORTH_TELLING = 2.0


def solve_jointly(prepared: Prepared) -> Answer:
    """Solve poses, light plane and the camera's free parameters by maximum likelihood.

    Raises
    ------
    NotConverged
        If the solve does not end, or contradicting stripes leave fewer than two.
    """
    layout = Layout(free_parameters(prepared.camera, prepared.role), plane=True)
    problem = Problem(
        prepared.observations,
        layout,
        _prior(prepared, layout),
        prepared.stripe_in,
        prepared.on_line,
    )
    estimate = Estimate.start(prepared.camera, prepared.plane, list(prepared.poses))
    let_in = np.zeros(len(prepared.views), dtype=bool)
    for _ in range(_ROUNDS):
        solution = solve(problem, estimate, near=True)
        believable = believable_stripes(problem, solution)
        # Left out and then found true, a stripe stays in: once it holds its pose almost alone,
        # the leverage formula has nothing left to judge it by.
        let_in |= believable & ~problem.stripe_in
        let_in |= acquitted(problem, solution, ~believable & ~let_in)
        fitting = believable | let_in
        if (fitting == problem.stripe_in).all() or fitting.sum() < 2:
            break
        problem, estimate = replace(problem, stripe_in=fitting), solution.estimate
    return _answer(prepared, problem, solution)


def free_parameters(camera: CameraModel, role: CameraRole) -> tuple[int, ...]:
    """Return the indices of the camera's parameters that a solve may move."""
    if role is CameraRole.HELD:
        return ()
    return tuple(int(index) for index in np.flatnonzero(np.diag(camera.covariance) > 0.0))


def camera_of(solution: Solution, layout: Layout, like: CameraModel) -> CameraModel:
    """Return the camera of a solution with its covariance, of the size of another camera."""
    sensor = sensor_covariance(solution, layout, like)
    count = len(PARAMETERS)
    return CameraModel.from_parameters(
        solution.estimate.camera,
        width=like.width,
        height=like.height,
        covariance=sensor[:count, :count],
    )


def sensor_covariance(solution: Solution, layout: Layout, camera: CameraModel) -> FloatArray:
    """Return the covariance of camera and plane, shape (13, 13); rows of what was held are 0."""
    jacobian = layout.sensor_from_global(solution.estimate)
    return np.asarray(jacobian @ solution.covariance.shared @ jacobian.T)


def dots_answer(problem: Problem, solution: Solution) -> PointsAnswer:
    """Return what became of the dots."""
    deviation = problem.observations.dots.seen_px - solution.dots.model_px
    return PointsAnswer(
        corrected_px=solution.dots.model_px,
        deviation_px=np.linalg.norm(deviation, axis=1),
        used=solution.dots_mixture.believed(solution.dots.residual),
    )


def report_of(problem: Problem, solution: Solution, role: CameraRole) -> SolveReport:
    """Return how a solve ended."""
    striped = bool(problem.stripe_in.any())
    return SolveReport(
        termination=Termination.CONVERGED,
        iterations=solution.iterations,
        cost=solution.cost,
        sigma_scale_dots=solution.dots_mixture.scale,
        sigma_scale_stripe=solution.stripe_mixture.scale if striped else 0.0,
        outlier_fraction_dots=solution.dots_mixture.share,
        outlier_fraction_stripe=solution.stripe_mixture.share if striped else 0.0,
        camera=role,
    )


def scale_warnings(report: SolveReport) -> tuple[str, ...]:
    """Tell where points scatter otherwise than predicted."""
    scales = (
        ("target points", report.sigma_scale_dots),
        ("stripe points", report.sigma_scale_stripe),
    )
    return tuple(
        f"the {kind} scatter {scale:.2g} times as much as predicted; the covariance accounts for it"
        for kind, scale in scales
        if scale > _SCALE_WORTH_TELLING
    )


def _prior(prepared: Prepared, layout: Layout) -> Prior | None:
    if prepared.role is not CameraRole.PRIOR:
        return None
    free = list(layout.camera)
    covariance = prepared.camera.covariance[np.ix_(free, free)]
    # Scaled before inverting: variances of fx and k2 differ by 1e8 and more.
    root = np.sqrt(np.diag(covariance))
    information = np.linalg.pinv(covariance / root / root[:, None], hermitian=True)
    return Prior(prepared.camera.parameters, information / root / root[:, None])


def _answer(prepared: Prepared, problem: Problem, solution: Solution) -> Answer:
    table = problem.observations.stripe
    believed = solution.stripe_mixture.believed(solution.stripe.residual)
    report = report_of(problem, solution, prepared.role)
    return Answer(
        camera=camera_of(solution, problem.layout, prepared.camera),
        plane=solution.estimate.plane,
        poses=tuple(solution.estimate.poses),
        covariance=sensor_covariance(solution, problem.layout, prepared.camera),
        dots=dots_answer(problem, solution),
        stripe=PointsAnswer(
            corrected_px=solution.stripe.model_px,
            deviation_px=np.abs(solution.stripe.residual[:, 0] * table.sigma_px),
            used=believed & problem.stripe_in[table.view],
        ),
        stripe_in=problem.stripe_in,
        report=report,
        warnings=scale_warnings(report),
    )
