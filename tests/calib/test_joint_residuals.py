"""The model of dots and stripe against geometry made otherwise, and its derivatives.

What these do not show: that pictures obey the model.
"""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_views import PAPER_SENSOR, SIZE, clean_stripe, disc_centroid, setting

from calib import CameraModel, LaserSensor, Target, View
from calib.solving.joint.parameters import Estimate, Layout, tangent_basis
from calib.solving.joint.residuals import linearise_dots, linearise_stripe
from calib.solving.observations import Observations

CAMERA = CameraModel.from_parameters(
    np.array([2181.0, 2190.0, 1024.0, 544.0, -0.45, 0.25, 1e-3, -2e-3, 0.03]), **SIZE
)
SENSOR = LaserSensor.exact(CAMERA, PAPER_SENSOR.plane)
DISCS = Target.parse("dots:10x10:10:d=5")
EVERYTHING = Layout(tuple(range(9)), plane=True)
# Central differences' steps: turn (rad), shift (mm), camera, normal's angles, offset.
STEPS = np.array([1e-6] * 3 + [1e-3] * 3 + [1e-2] * 4 + [1e-6] * 5 + [1e-6] * 2 + [1e-3])


def noisy_case(rng, target=DISCS, stripe_count=30):
    place = setting(rng, 4, sensor=SENSOR, target=target)
    views = place.views(rng, dots_px=0.5, stripe_px=0.5, stripe_count=stripe_count)
    estimate = Estimate.start(CAMERA, SENSOR.plane, list(place.poses))
    return place, views, Observations.of(views, target), estimate


def differences(function, estimate, index):
    """Return d(model)/d(parameter) over sigma by central differences."""
    ends = []
    for sign in (1.0, -1.0):
        shared, poses = np.zeros(EVERYTHING.size), np.zeros((len(estimate.rotation), 6))
        if index < 6:
            poses[:, index] = sign * STEPS[index]
        else:
            shared[index - 6] = sign * STEPS[index]
        ends.append(function(EVERYTHING.moved(estimate, shared, poses)).residual)
    return -(ends[0] - ends[1]) / (2.0 * STEPS[index])


@pytest.mark.parametrize("target", [DISCS, replace(DISCS, diameter_mm=None)], ids=str)
def test_dot_jacobian_agrees_with_central_differences(rng, target):
    _, _, seen, estimate = noisy_case(rng, target)
    linear = linearise_dots(seen, estimate, EVERYTHING)
    # What the lens does to the ellipse is held constant in the Jacobian: below 5e-3 of k3's
    # column, the smallest, and 1e-4 of the others.
    part = 5e-3 if target.diameter_mm else 1e-6
    for index in range(len(STEPS)):
        expected = differences(
            lambda moved: linearise_dots(seen, moved, EVERYTHING), estimate, index
        )
        column = linear.jacobian[:, :, index]
        np.testing.assert_allclose(column, expected, atol=part * np.abs(expected).max() + 1e-6)


def test_stripe_jacobian_agrees_with_central_differences(rng):
    _, _, seen, estimate = noisy_case(rng)
    linear = linearise_stripe(seen.stripe, estimate, EVERYTHING)
    for index in range(len(STEPS)):
        expected = differences(
            lambda moved: linearise_stripe(seen.stripe, moved, EVERYTHING), estimate, index
        )
        np.testing.assert_allclose(
            linear.jacobian[:, :, index], expected, atol=2e-6 * np.abs(expected).max()
        )


def test_stripe_residual_is_the_distance_along_the_normal_to_the_traced_line(rng):
    place, _, _, estimate = noisy_case(rng)
    for index, pose in enumerate(place.poses):
        clean = clean_stripe(SENSOR, DISCS, pose, 50)
        offset = rng.uniform(-20.0, 20.0, len(clean))
        # Away from the stripe by a known distance along a direction 20 degrees off its normal.
        turn = np.array([[np.cos(0.35), -np.sin(0.35)], [np.sin(0.35), np.cos(0.35)]])
        direction = clean.normal @ turn.T
        shifted = replace(
            clean, centre_px=clean.centre_px + offset[:, None] * direction, normal=direction
        )
        view = replace(place.clean_view(index, 5), stripe=shifted)
        own = Estimate.start(CAMERA, SENSOR.plane, [pose])
        table = Observations.of([view], DISCS).stripe
        linear = linearise_stripe(table, own, Layout((), plane=True))
        found = linear.residual[:, 0] * table.sigma_px
        # The search along the normal takes one Newton step on the lens: 20 px off, that leaves
        # less than the curvature of the distortion, 1e-6 per px, times the square.
        np.testing.assert_allclose(found, offset, atol=1e-3)
        np.testing.assert_allclose(linear.model_px, clean.centre_px, atol=1e-3)
    assert len(estimate.rotation) == len(place.poses)


def test_modelled_disc_centroid_is_that_of_a_disc_drawn_point_by_point(rng):
    big = Target.parse("dots:3x3:40:d=30")
    place = setting(rng, 5, sensor=SENSOR, target=big, tilt_rad=0.8)
    for index, pose in enumerate(place.poses):
        view = View("a", place.clean_view(index, 5).points, None)
        estimate = Estimate.start(CAMERA, SENSOR.plane, [pose])
        seen = Observations.of([view], big)
        model = linearise_dots(seen, estimate, Layout((), plane=False)).model_px
        truth = np.array([disc_centroid(CAMERA, pose, point, 30.0) for point in big.points_mm])
        naive = CAMERA.project(pose.apply(big.points_mm))
        # A dot of 30 mm is moved by a third of a pixel; the model's rest is of fourth order in the
        # radius, (0.03)^2 of that. The drawing's own error is 1e-3 px.
        assert np.linalg.norm(truth - naive, axis=1).max() > 0.2
        np.testing.assert_allclose(model, truth, atol=5e-3)


def test_tangent_basis_is_orthonormal_and_across_the_normal(rng):
    for normal in rng.normal(size=(20, 3)):
        normal /= np.linalg.norm(normal)
        frame = np.column_stack([tangent_basis(normal), normal])
        np.testing.assert_allclose(frame.T @ frame, np.eye(3), atol=1e-14)


def test_sensor_jacobian_agrees_with_moving_the_state(rng):
    _, _, _, estimate = noisy_case(rng)
    # Also with the offset's sign the other way, which the sensor turns back.
    for state in (estimate, replace(estimate, normal=-estimate.normal, offset_mm=-213.0)):
        jacobian = EVERYTHING.sensor_from_global(state)
        for index in range(EVERYTHING.size):
            ends = []
            for sign in (1.0, -1.0):
                shared = np.zeros(EVERYTHING.size)
                shared[index] = sign * STEPS[6 + index]
                moved = EVERYTHING.moved(state, shared, np.zeros((len(state.rotation), 6)))
                ends.append(np.append(moved.camera, moved.plane.coefficients))
            difference = (ends[0] - ends[1]) / (2.0 * STEPS[6 + index])
            np.testing.assert_allclose(jacobian[:, index], difference, atol=1e-7)
