"""The Cramér-Rao bound: how well any unbiased method can know the sensor from given views."""

from collections.abc import Sequence

import numpy as np

from calib.arrays import FloatArray
from calib.rigid import RigidTransform
from calib.sensor import LaserSensor
from calib.solving.joint.normal_equations import NormalEquations
from calib.solving.joint.parameters import Estimate, Layout
from calib.solving.joint.residuals import linearise_dots, linearise_stripe
from calib.solving.observations import Observations
from calib.target import Target
from calib.views import View


def cramer_rao_bound(
    views: Sequence[View],
    target: Target,
    sensor: LaserSensor,
    poses: Sequence[RigidTransform],
    *,
    free_camera: Sequence[int] = (),
) -> FloatArray:
    r"""Return the smallest covariance of the sensor that these views allow.

    Parameters
    ----------
    views
        M views; their sigma say how their points scatter, independently and normally.
    target, sensor, poses
        The truth: the target, the sensor (its covariance is not looked at), and cam_from_board of
        each view.
    free_camera
        Indices into `calib.camera.PARAMETERS` of those that are not known.

    Returns
    -------
    covariance
        Shape (13, 13), in the order of `calib.sensor.SENSOR_PARAMETERS`.

    Raises
    ------
    NotConverged
        If the views leave a parameter undetermined.

    Notes
    -----
    The inverse of Fisher's information :math:`J^T \Sigma^{-1} J` of all unknowns, poses included,
    brought to the sensor's parameters [1]_.

    References
    ----------
    .. [1] S. M. Kay, "Fundamentals of Statistical Signal Processing: Estimation Theory", Prentice
       Hall, 1993, section 3.9.
    """
    seen = Observations.of(views, target)
    layout = Layout(tuple(sorted(free_camera)), plane=True)
    truth = Estimate.start(sensor.camera, sensor.plane, list(poses))
    dots = linearise_dots(seen, truth, layout)
    stripe = linearise_stripe(seen.stripe, truth, layout)
    information = NormalEquations.of(
        dots, np.ones(len(seen.dots)), seen.dots.view, seen.count
    ) + NormalEquations.of(stripe, np.ones(len(seen.stripe)), seen.stripe.view, seen.count)
    to_sensor = layout.sensor_from_global(truth)
    return np.asarray(to_sensor @ information.covariance().shared @ to_sensor.T)
