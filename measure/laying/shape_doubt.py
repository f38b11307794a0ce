"""What a flange's shape leaves open of how a sheet cuts the wheel, where no survey tells it.

Two things are not known: how well the flange keeps to its drawing, which turns the section, and
how oblique the cut is, which stretches it. Neither shows in the scatter of the points.
"""

from dataclasses import dataclass

import numpy as np

from calib import FloatArray
from measure.laying.section import Section
from measure.mounting import Survey
from measure.placing.template import Template

# Flanges keep to their drawing to 0.1 mm, alike over a few millimetres: two wheels measured by
# contact lie 0.12 mm off the nearer reference, in waves of 10 to 15 mm.
_SIGMA_FORM_MM = 0.1
_FORM_LENGTH_MM = 10.0
# A line turned into the plane of the wheel's radius by eye is out of it by 3 degrees; an axle 60 mm
# from its place adds 6 degrees where the sheet runs 45 degrees below the horizon.
_SIGMA_YAW_RAD = np.radians(3.0)
_SIGMA_LEAN_RAD = np.radians(6.5)
_RADIUS_MM = Survey().wheel_radius_mm
# 1 mm of u95 in flange height, 55 mm from tip to tape circle: what is known less well is not given.
_MOST_SIGMA_TURN_RAD = 9e-3
# Of three strains, as a chi-square: 4 of 100 drawn wheels that are as said above pass it, and 9 of
# 10 that are cut 20 degrees out of the radial plane.
_MOST_STRAIN = 5.0
# What each place has by itself: pits, scatter, left-over bends. So much that no single place tells
# of the whole flange.
_SIGMA_SPOT_MM = 0.05
_LEAST_SPOTS = 12
_NO_HOLD = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class ShapeDoubt:
    """What may be wrong with a section that was laid by its flange.

    Attributes
    ----------
    motions_mm
        Shape (N, 2, 6): what the points of the section may do, one sigma each: by the flange's
        form, which turns and shifts it (3), and by the strains of an oblique cut (3).
    sigma_turn_rad
        Of the section's direction, by the flange's form.
    strain
        How far the flange is strained beyond what form and mounting explain: chi-square of 3.
    """

    motions_mm: FloatArray
    sigma_turn_rad: float
    strain: float

    @classmethod
    def of(cls, section: Section, shift_mm: FloatArray, template: Template) -> "ShapeDoubt":
        """Tell the doubt of a section by what it shows of the unworn flange.

        Parameters
        ----------
        section, shift_mm
            As it was laid: (y, z) of the reference = (a, r) - shift.
        template
            The reference it was laid on.

        Notes
        -----
        Laying fits a turn and two shifts, x, to the heights h over the unworn reference by least
        squares: x = P h. The flange's form, a smooth h of known sigma and length, moves x by
        P C P'. A strain that displaces the points by D s shows heights n D s, of which the fit
        takes what it can: D s - G P n D s is left, with G the motions by x.
        """
        places = section.points_mm - shift_mm
        _, outside, nearest = template.place(places)
        facing = np.sum(section.to_camera * template.outward[nearest], axis=1) > 0.0
        # What lies off either end of the unworn drawing is nearest to that end.
        unworn = facing & (nearest > 0) & (nearest < template.tip)
        spots, of_spot, counts = np.unique(nearest[unworn], return_inverse=True, return_counts=True)
        heights = np.bincount(of_spot, outside[unworn]) / counts
        # By the drawing's places, not by the points': their scatter would pass for strain.
        drawn, normal = template.points_mm[spots], template.outward[spots]
        by_rigid, by_strain = (
            np.einsum("ni,nij->nj", normal, motions(drawn))
            for motions in (rigid_motions, oblique_motions)
        )
        rigid, strains = rigid_motions(places), oblique_motions(places)
        # Back or tip by itself, or neither: something turns or shifts and no height changes.
        if len(spots) < _LEAST_SPOTS or np.linalg.matrix_rank(by_rigid, rtol=_NO_HOLD) < 3:
            return cls(np.concatenate([rigid, strains], axis=2), np.inf, 0.0)
        root = np.sqrt(counts)
        fit = np.linalg.pinv(by_rigid * root[:, None]) * root
        form = _form(template.along_mm[spots])
        laid = fit @ form @ fit.T
        left = strains - rigid @ (fit @ by_strain)
        motions = [rigid @ np.linalg.cholesky(laid), left @ np.linalg.cholesky(expected_strains())]
        return cls(
            np.concatenate(motions, axis=2),
            float(np.sqrt(laid[0, 0])),
            _strain(heights, np.concatenate([by_rigid, by_strain], axis=1), form),
        )

    @property
    def refusal(self) -> str | None:
        """Say why the section cannot be read, or None where it can."""
        if not self.sigma_turn_rad <= _MOST_SIGMA_TURN_RAD:
            return (
                "half a wheel: too little of the flange back is seen to tell how the wheel lies in "
                "the sheet; survey the sensor, or measure it with its rig"
            )
        if not self.strain <= _MOST_STRAIN:
            return (
                "no wheel: the flange is strained as by a sheet far out of the wheel's radial "
                "plane; survey the sensor, turn the laser's line into that plane, or give the "
                "reference of this wheel"
            )
        return None


def rigid_motions(places_mm: FloatArray) -> FloatArray:
    """Return motions of (y, z) by a turn about (0, 0), and by shifts along both; (N, 2, 3)."""
    y, z = places_mm.T
    one, none = np.ones_like(y), np.zeros_like(y)
    columns = [[-z, y], [one, none], [none, one]]
    return np.stack([np.stack(each, axis=1) for each in columns], axis=2)


def oblique_motions(places_mm: FloatArray) -> FloatArray:
    r"""Return motions of (y, z) by the strains of an oblique cut, shape (N, 2, 3).

    Notes
    -----
    A sheet meets the wheel at the tape circle. There it runs along the rim by
    :math:`t = q_y y + q_z z`: q is (0, 0) for a radial cut, :math:`q_y` the tangent of a yaw
    about the radius, :math:`q_z` that of a lean about the axle's direction. Lengths in the sheet
    are those of the section and t, and a point at t is nearer to the rim's tangent than its
    radius tells, by :math:`t^2 / 2 R`. To second order in q all of it is linear in the strains
    :math:`S = q q^T / 2`,

    .. math:: (y, z) \to (y, z) + S (y, z) - (0, (y, z)^T S (y, z) / R)

    whose columns are :math:`S_{yy}, S_{yz}, S_{zz}`.
    """
    y, z = places_mm.T
    none = np.zeros_like(y)
    columns = [
        [y, -(y**2) / _RADIUS_MM],
        [z, y - 2.0 * y * z / _RADIUS_MM],
        [none, z - z**2 / _RADIUS_MM],
    ]
    return np.stack([np.stack(each, axis=1) for each in columns], axis=2)


def expected_strains() -> FloatArray:
    """Return the mean squares of the strains, shape (3, 3), by what mountings allow.

    About zero, not about their mean: a reading is not made smaller for a cut that may be radial.
    """
    yaw, lean = _SIGMA_YAW_RAD**2, _SIGMA_LEAN_RAD**2
    return np.array([
        [3.0 * yaw**2, 0.0, yaw * lean],
        [0.0, yaw * lean, 0.0],
        [yaw * lean, 0.0, 3.0 * lean**2],
    ]) / 4.0  # fmt: skip


def _form(along_mm: FloatArray) -> FloatArray:
    """Return the covariance of heights over the drawing at places along the flange."""
    apart = (along_mm[:, None] - along_mm) / _FORM_LENGTH_MM
    form = _SIGMA_FORM_MM**2 * np.exp(-0.5 * apart**2)
    return np.asarray(form + _SIGMA_SPOT_MM**2 * np.eye(len(along_mm)))


def _strain(heights_mm: FloatArray, design: FloatArray, form: FloatArray) -> float:
    """Return chi-square of the strains that heights show, by what form and mounting allow."""
    certain = np.linalg.solve(form, design)
    covariance = np.linalg.pinv(design.T @ certain, hermitian=True)[3:]
    shown = covariance @ (certain.T @ heights_mm)
    return float(shown @ np.linalg.solve(covariance[:, 3:] + expected_strains(), shown))
