"""Where the axle stood when the picture was taken: solved from the tread the wheel rolls on."""

from dataclasses import dataclass

import numpy as np

from calib import FloatArray, RigidTransform, frozen
from measure.laying.section import AxleMap
from measure.mounting import Survey

_ITERATIONS = 8


@dataclass(frozen=True, slots=True, eq=False)
class Axle:
    """The axle's place and what is not known of it.

    Attributes
    ----------
    x_mm, z_mm
        Place in the rig frame; z is the wheel's radius at the tape circle.
    by_place_mm, by_radius_mm, by_height_mm
        Shape (2,): by how much (x, z) is off for one sigma of what was taken for known: where
        along the rail the axle stands, the wheel's radius, the height of its tread. The first is
        another in every picture, the other two are the same in all pictures of a wheel.
    by_vibration_mm
        Shape (2, K): the same for what each of K sheets moved by itself; empty for one sheet.
    """

    x_mm: float
    z_mm: float
    by_place_mm: FloatArray
    by_radius_mm: FloatArray
    by_height_mm: FloatArray
    by_vibration_mm: FloatArray

    @classmethod
    def exact(cls, x_mm: float, z_mm: float) -> "Axle":
        """Make an axle whose place is not in doubt."""
        return cls(x_mm, z_mm, np.zeros(2), np.zeros(2), np.zeros(2), np.zeros((2, 0)))

    @property
    def covariance(self) -> FloatArray:
        """Of (x, z), shape (2, 2), mm²."""
        causes = [self.by_place_mm, self.by_radius_mm, self.by_height_mm, *self.by_vibration_mm.T]
        return np.asarray(np.stack(causes).T @ np.stack(causes))

    def map(self, rig_from_camera: RigidTransform) -> AxleMap:
        """Return the section map of a camera by this axle."""
        return AxleMap(rig_from_camera, self.x_mm, self.z_mm)


def solve_axle(treads_in_rig_mm: FloatArray, survey: Survey, radial_x_mm: float) -> Axle:
    r"""Solve the axle from the points of the tape circle that the sheets meet.

    Parameters
    ----------
    treads_in_rig_mm
        Shape (K, 2), (x, z) of the tread at the tape circle, one for each sheet that meets it.
    survey
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

    One equation for x and R of each sheet. With R ~ N(nominal, sigma_radius), x ~ N(radial place,
    sigma_axle_x) and the equations true to sigma_height all together, and each by itself to what
    its sensor vibrates, the most probable (x, R) is found by Gauss-Newton. Near a
    radial cut the section depends on the error left in it to second order only; a sheet that comes
    from straight below does not tell x, and the prior then stands.

    The error of (x, R) is linear in those of the things assumed; with :math:`\Lambda` the matrix
    of the normal equations, G the slopes of the equations and W the inverse of their covariance
    it is :math:`\Lambda^{-1} (e_x / \sigma_x^2, e_R / \sigma_R^2)^T - \Lambda^{-1} G^T W e_h`,
    whose parts make up :math:`\Lambda^{-1}`.
    """
    prior = np.array([radial_x_mm, survey.wheel_radius_mm])
    sigma = np.array([survey.sigma_axle_x_mm, survey.sigma_radius_mm])
    state = prior.copy()
    information = np.diag(1.0 / sigma**2)
    alike = np.full(len(treads_in_rig_mm), survey.sigma_height_mm)
    alone = np.zeros((len(alike), 0))
    if len(alike) > 1:
        alone = np.eye(len(alike)) * survey.sigma_vibration_mm / np.sqrt(2.0)
    certainty = np.linalg.inv(np.outer(alike, alike) + alone @ alone.T)
    for _ in range(_ITERATIONS):
        offset = treads_in_rig_mm - state
        distance = np.hypot(*offset.T)
        misfit = distance - state[1]
        slope = np.column_stack([-offset[:, 0] / distance, -offset[:, 1] / distance - 1.0])
        pull = slope.T @ certainty
        normal = information + pull @ slope
        step = np.linalg.solve(normal, information @ (state - prior) + pull @ misfit)
        state -= step
        if np.abs(step).max() < 1e-6:
            break
    covariance = np.linalg.inv(normal)
    return Axle(
        float(state[0]),
        float(state[1]),
        by_place_mm=frozen(covariance[:, 0] / sigma[0], (2,), "by_place_mm"),
        by_radius_mm=frozen(covariance[:, 1] / sigma[1], (2,), "by_radius_mm"),
        by_height_mm=frozen(-covariance @ pull @ alike, (2,), "by_height_mm"),
        by_vibration_mm=-covariance @ pull @ alone,
    )
