"""A second stripe, as bright and straight as the true one, is told apart over the pictures.

It does not show that pictures yield both lines; `test_observe_target.py` beside it does.
"""

from dataclasses import replace

import numpy as np
import pytest
from synthetic_views import LED_TARGET, PAPER_SENSOR, SIZE, clean_stripe, noisy, setting

from calib import Cause, LaserSensor, LightPlane, RigidTransform, calibrate

FALSE_FIRST = 0.7


def with_false_stripes(rng, scene, views):
    """Give each view a second stripe in a plane of its own; most often it comes first."""
    return [
        exchanged(with_rival(view, false_stripe(rng, scene, pose)), rng.random() < FALSE_FIRST)
        for view, pose in zip(views, scene.poses, strict=True)
    ]


def false_stripe(rng, scene, pose):
    """The stripe of the sheet turned by some degrees and moved by some millimetres."""
    turn = RigidTransform.from_rotation_vector(rng.normal(0.0, 0.1, 3), np.zeros(3))
    plane = scene.sensor.plane
    normal = turn.apply(plane.normal_in_cam[None])[0]
    through = pose.apply(scene.target.points_mm.mean(axis=0)[None])[0]
    through = through + plane.normal_in_cam * rng.choice([-1.0, 1.0]) * rng.uniform(8.0, 25.0)
    sheet = LightPlane.from_coefficients([*normal, -normal @ through])
    sensor = LaserSensor.exact(scene.sensor.camera, sheet)
    return clean_stripe(sensor, scene.target, pose, 20)


def with_rival(view, stripe):
    return replace(view, rivals=(stripe,))


def exchanged(view, wanted):
    return replace(view, stripe=view.rivals[0], rivals=(view.stripe,)) if wanted else view


@pytest.fixture
def scene(rng):
    return setting(rng, 12, target=LED_TARGET)


def test_true_stripe_is_chosen_though_the_false_one_comes_first_in_most_views(rng, scene):
    views = scene.views(rng, dots_px=0.05, stripe_px=0.1, stripe_count=20)
    doubtful = with_false_stripes(rng, scene, views)
    answer = calibrate(doubtful, LED_TARGET, camera=PAPER_SENSOR.camera, **SIZE)
    for seen, true in zip(answer.seen, views, strict=True):
        np.testing.assert_array_equal(seen.stripe.centre_px, true.stripe.centre_px)
    assert all(view.stripe.used.any() for view in answer.views)


def test_answer_is_that_of_pictures_without_a_false_stripe(rng, scene):
    views = scene.views(rng, dots_px=0.05, stripe_px=0.1, stripe_count=20)
    doubtful = with_false_stripes(rng, scene, views)
    plain = calibrate(views, LED_TARGET, camera=PAPER_SENSOR.camera, **SIZE)
    settled = calibrate(doubtful, LED_TARGET, camera=PAPER_SENSOR.camera, **SIZE)
    np.testing.assert_array_equal(
        settled.sensor.plane.coefficients, plain.sensor.plane.coefficients
    )


def test_views_without_rivals_are_used_as_they_are(rng, scene):
    views = scene.views(rng, dots_px=0.05, stripe_px=0.1)
    answer = calibrate(views, LED_TARGET, camera=PAPER_SENSOR.camera, **SIZE)
    assert all(seen is given for seen, given in zip(answer.seen, views, strict=True))


def test_rival_nearer_by_chance_does_not_take_the_place_of_a_stripe_that_agrees(rng, scene):
    views = scene.views(rng, dots_px=0.05, stripe_px=0.1, stripe_count=20)
    twins = [
        replace(view, rivals=(noisy(scene.clean_view(i, 20), rng, 0.05, 0.1).stripe,))
        for i, view in enumerate(views)
    ]
    answer = calibrate(twins, LED_TARGET, camera=PAPER_SENSOR.camera, **SIZE)
    kept = [seen.stripe is given.stripe for seen, given in zip(answer.seen, twins, strict=True)]
    # Both lie on the plane: what the picture found likelier stays, but for chance beyond 4 sigma.
    assert sum(kept) >= 10


def test_stripe_that_is_false_is_stray_light_whatever_its_points_look_like(rng, scene):
    views = scene.views(rng, dots_px=0.05, stripe_px=0.1, stripe_count=20)
    false = false_stripe(rng, scene, scene.poses[0])
    views[0] = replace(views[0], stripe=replace(false, cause=(Cause.SATURATED,) * len(false)))
    answer = calibrate(views, LED_TARGET, camera=PAPER_SENSOR.camera, **SIZE)
    assert not answer.views[0].stripe.used.any()
    assert set(answer.views[0].stripe.cause) == {Cause.STRAY_LIGHT}
