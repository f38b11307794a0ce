"""Where the axle stood when the picture was taken: solved from the tread the wheel rolls on."""

from dataclasses import dataclass

import numpy as np

from calib import FloatArray, frozen
from measure.mounting import Mounting
from measure.section import AxleMap

_ITERATIONS = 8


@dataclass(frozen=True, slots=True, eq=False)
class Axle:
    """The axle's place and what is not known of it.

    Attributes
    ----------
    x_mm, z_mm
        Place in the rig frame; z is the wheel's radius at the tape circle.
    covariance
        Shape (2, 2), of (x, z), mm².
    """

    x_mm: float
    z_mm: float
    covariance: FloatArray

    def map(self, mounting: Mounting) -> AxleMap:
        """Return the section map by this axle."""
        return AxleMap(mounting.rig_from_camera, self.x_mm, self.z_mm)


def solve_axle(tread_in_rig_mm: FloatArray, mounting: Mounting, radial_x_mm: float) -> Axle:
    r"""Solve the axle from the point of the tape circle that the sheet meets.

    Parameters
    ----------
    tread_in_rig_mm
        Shape (2,), (x, z) of the tread at the tape circle.
    mounting
        What is known beforehand: the radius, and how near the sheet axles stand.
    radial_x_mm
        The x at which the axle would lie in the sheet.

    Returns
    -------
    Axle

    Notes
    -----
    A wheel stands on the rail, so its axle is as high as its radius:

    .. math:: (x_t - x)^2 + (z_t - R)^2 = R^2

    One equation for x and R. With R ~ N(nominal, sigma_radius), x ~ N(radial place,
    sigma_axle_x) and the equation true to sigma_height, the most probable (x, R) is found by
    Gauss-Newton. Near a radial cut the section depends on the error left in it to second order
    only; a sheet that comes from straight below does not tell x, and the prior then stands.
    """
    prior = np.array([radial_x_mm, mounting.wheel_radius_mm])
    sigma = np.array([mounting.sigma_axle_x_mm, mounting.sigma_radius_mm])
    state = prior.copy()
    information = np.diag(1.0 / sigma**2)
    for _ in range(_ITERATIONS):
        offset = tread_in_rig_mm - state
        distance = float(np.hypot(*offset))
        misfit = distance - state[1]
        slope = np.array([-offset[0] / distance, -offset[1] / distance - 1.0])
        normal = information + np.outer(slope, slope) / mounting.sigma_height_mm**2
        gradient = information @ (state - prior) + slope * misfit / mounting.sigma_height_mm**2
        step = np.linalg.solve(normal, gradient)
        state -= step
        if np.abs(step).max() < 1e-6:
            break
    return Axle(
        float(state[0]), float(state[1]), frozen(np.linalg.inv(normal), (2, 2), "covariance")
    )
