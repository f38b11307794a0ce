"""Method `deviation`: the paper's own, the explicit deviation of every dot and stripe point.

The deviations are found first, within bounds of nine sigma (`relocate`). The points, corrected by
them, then give the light plane as in method `preplanar`, and a last non-linear step makes it the
most likely one. The camera is held. A disc's picture is taken as centred on its middle's, as the
paper does.
"""

from dataclasses import replace

import numpy as np

from calib.arrays import FloatArray
from calib.calibration import SolveReport, Termination
from calib.camera import PARAMETERS
from calib.errors import NotConverged
from calib.lines import fit_plane
from calib.plane import LightPlane
from calib.solving.deviation.corrected import Corrected
from calib.solving.deviation.reach import SIGMAS_ALLOWED, Reach
from calib.solving.deviation.relocation import Relocation, relocate
from calib.solving.deviation.state import RIGID
from calib.solving.joint.normal_equations import NormalEquations
from calib.solving.joint.parameters import POSE_SIZE, Estimate, Layout
from calib.solving.joint.residuals import linearise_dots, linearise_stripe
from calib.solving.prepared import Answer, PointsAnswer, Prepared
from calib.solving.preplanar import (
    consensus,
    crossed_by_stripes,
    points_in_cam,
    sensor_covariance,
)
from calib.views import View

_PLANE_STEPS = 20
_PLANE_SETTLED = 1e-6


def solve_deviation(prepared: Prepared) -> Answer:
    """Correct every point, then solve the light plane from the corrected points.

    Raises
    ------
    TooFewViews
        If the stripes cross fewer than two views' columns.
    NotConverged
        If the points leave a pose or the plane undetermined, as where most of them are not of one
        target and one light plane.

    Notes
    -----
    A point that nine sigma cannot carry onto the board as its robust pose has it, or onto its
    stripe's line, takes no part: one such dot would drag the others to their bounds. Where points
    scatter more than their sigmas say, these are scaled first. The covariance is that of least
    squares at the answer, its sigmas scaled by what the deviations show, plus what the camera's
    own covariance adds.
    """
    reach = Reach.of(prepared)
    start = Estimate.start(prepared.camera, prepared.plane, list(prepared.poses))
    frame = reach.frame(prepared)
    relocation = relocate(frame, frame.started(start))
    corrected = Corrected.of(frame, relocation.state)
    dots, stripe = _answers(prepared, reach, corrected)
    first = _first_plane(prepared, dots, stripe)
    estimate = _most_likely_plane(
        corrected,
        replace(relocation.state.estimate, normal=first.normal_in_cam, offset_mm=first.offset_mm),
    )
    own, by_camera = _plane_covariance(prepared, corrected, estimate)
    return Answer(
        camera=prepared.camera,
        plane=estimate.plane,
        poses=tuple(estimate.poses),
        covariance=sensor_covariance(prepared, own, by_camera),
        dots=dots,
        stripe=stripe,
        stripe_in=prepared.stripe_in,
        report=_report(prepared, reach, corrected, relocation, dots, stripe),
        warnings=_warnings(relocation),
    )


def _answers(
    prepared: Prepared, reach: Reach, corrected: Corrected
) -> tuple[PointsAnswer, PointsAnswer]:
    """Return what became of all points; those out of reach are put where the answer has them."""
    seen, estimate = replace(prepared.observations, radius_mm=0.0), corrected.state.estimate
    dots = linearise_dots(seen, estimate, RIGID).model_px.copy()
    stripe = linearise_stripe(seen.stripe, estimate, RIGID).model_px.copy()
    dots[reach.dots] = corrected.observations.dots.seen_px
    stripe[reach.stripe] = corrected.observations.stripe.seen_px
    dots_used, stripe_used = reach.dots.copy(), reach.stripe.copy()
    dots_used[reach.dots] = corrected.dots_free
    stripe_used[reach.stripe] = corrected.stripe_free
    across = np.einsum("ni,ni->n", seen.stripe.seen_px - stripe, seen.stripe.normal)
    return (
        PointsAnswer(dots, np.linalg.norm(seen.dots.seen_px - dots, axis=1), dots_used),
        PointsAnswer(stripe, np.abs(across), stripe_used),
    )


def _first_plane(prepared: Prepared, dots: PointsAnswer, stripe: PointsAnswer) -> LightPlane:
    """Return the plane as method `preplanar` finds it, from corrected points."""
    seen = prepared.observations
    views = tuple(
        _corrected_view(
            view,
            dots.corrected_px[seen.dots.view == index],
            stripe.corrected_px[seen.stripe.view == index],
        )
        for index, view in enumerate(prepared.views)
    )
    corrected = replace(prepared, views=views)
    points = points_in_cam(corrected, prepared.camera, crossed_by_stripes(corrected))
    return LightPlane.from_coefficients(fit_plane(points[consensus(points)]))


def _corrected_view(view: View, dots_px: FloatArray, stripe_px: FloatArray) -> View:
    points = replace(view.points, centre_px=dots_px)
    if view.stripe is None:
        return replace(view, points=points)
    return replace(view, points=points, stripe=replace(view.stripe, centre_px=stripe_px))


def _most_likely_plane(corrected: Corrected, estimate: Estimate) -> Estimate:
    """Solve the plane alone by least squares over the corrected stripe points (Gauss-Newton)."""
    stripe, free = corrected.observations.stripe, corrected.stripe_free
    still = np.zeros((corrected.seen.count, POSE_SIZE))
    for _ in range(_PLANE_STEPS):
        linear = linearise_stripe(stripe, estimate, RIGID)
        jacobian, residual = linear.jacobian[free, 0, POSE_SIZE:], linear.residual[free, 0]
        step, *_ = np.linalg.lstsq(jacobian, residual)
        estimate = RIGID.moved(estimate, step, still)
        if np.linalg.norm(jacobian @ step) < _PLANE_SETTLED:
            break
    return estimate


def _plane_covariance(
    prepared: Prepared, corrected: Corrected, estimate: Estimate
) -> tuple[FloatArray, FloatArray]:
    """Return the plane's own covariance, (4, 4), and d(a, b, c, d)/d(camera), (4, 9)."""
    free = tuple(int(i) for i in np.flatnonzero(np.diag(prepared.camera.covariance) > 0.0))
    layout, moved = Layout(free, plane=True), corrected.observations
    dots = NormalEquations.of(
        linearise_dots(moved, estimate, layout),
        corrected.dots_free / corrected.scale_dots**2,
        moved.dots.view,
        moved.count,
    )
    stripe = NormalEquations.of(
        linearise_stripe(moved.stripe, estimate, layout),
        corrected.stripe_free / (corrected.scale_stripe**2 * corrected.stripe_run),
        moved.stripe.view,
        moved.count,
    )
    total = dots + stripe
    plane, camera = layout.plane_columns, layout.camera_columns
    try:
        by_border = np.linalg.solve(total.views, total.border)
        schur = total.shared - np.einsum("vij,vik->jk", total.border, by_border)
        own = np.linalg.inv(schur[plane, plane])
    except np.linalg.LinAlgError as error:
        raise NotConverged(
            f"deviations within {SIGMAS_ALLOWED:g} sigma do not carry the dots and stripes of all "
            "pictures onto the target and one light plane; look at the residuals that method joint "
            "shows, and leave out what does not fit"
        ) from error
    to_sensor = layout.sensor_from_global(estimate)[len(PARAMETERS) :, plane]
    by_camera = np.zeros((4, len(PARAMETERS)))
    by_camera[:, list(free)] = -to_sensor @ own @ schur[plane, camera]
    return to_sensor @ own @ to_sensor.T, by_camera


def _report(
    prepared: Prepared,
    reach: Reach,
    corrected: Corrected,
    relocation: Relocation,
    dots: PointsAnswer,
    stripe: PointsAnswer,
) -> SolveReport:
    return SolveReport(
        termination=Termination.CONVERGED if relocation.settled else Termination.STEP_LIMIT,
        iterations=relocation.steps,
        cost=relocation.cost,
        sigma_scale_dots=corrected.scale_dots * reach.widened_dots,
        sigma_scale_stripe=corrected.scale_stripe * reach.widened_stripe,
        outlier_fraction_dots=float(1.0 - dots.used.mean()),
        outlier_fraction_stripe=float(1.0 - stripe.used.mean()),
        camera=prepared.role,
        on_bound=_beyond_bounds(prepared, dots, stripe),
    )


def _beyond_bounds(prepared: Prepared, dots: PointsAnswer, stripe: PointsAnswer) -> tuple[str, ...]:
    """Name what its bounds keep from the answer: each dot, and how many stripe points a view."""
    seen, pitch = prepared.observations, prepared.target.pitch_mm
    names = [
        f"{prepared.views[seen.dots.view[dot]].name}: dot at row {row}, column {column}"
        for dot in np.flatnonzero(~dots.used)
        for column, row in [np.rint(seen.dots.board_mm[dot, :2] / pitch).astype(int)]
    ]
    believed = prepared.stripe_in[seen.stripe.view]
    counts = np.bincount(seen.stripe.view[believed & ~stripe.used], minlength=seen.count)
    names += [
        f"{prepared.views[view].name}: {counts[view]} stripe points"
        for view in np.flatnonzero(counts)
    ]
    return tuple(names)


def _warnings(relocation: Relocation) -> tuple[str, ...]:
    if relocation.settled:
        return ()
    return (
        f"the search for deviations within {SIGMAS_ALLOWED:g} sigma still moved after "
        f"{relocation.steps} steps; compare with method joint",
    )
