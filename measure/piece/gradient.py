"""Linear estimates from the points on a piece that no motion of it changes."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from calib import BoolArray, FloatArray
from measure.piece.laid import LaidPoints

# An eigenvalue this small beside the largest: the points do not tell this combination.
_SINGULAR = 1e-5
BEND_SHARE = 0.7
"""What blur does on round sides is known to this share of itself."""


@dataclass(frozen=True, slots=True, eq=False)
class Dimension:
    """One dimension of the piece as one picture shows it.

    Attributes
    ----------
    name
        Which it is, the same in every picture.
    certified_mm
        Its certified value.
    off_mm
        Found less certified.
    noise_mm
        Standard deviation by the points, afresh with every placement.
    by_sensor_mm
        Shape (P,): change by the parameters of the sensor, or of the rig, the same in every
        picture.
    by_slant_mm
        Shape (2,): change for one sigma of each turn of the piece from square to the sheet.
    bend_mm
        Standard deviation by what blur does on round sides.
    """

    name: str
    certified_mm: float
    off_mm: float
    noise_mm: float
    by_sensor_mm: FloatArray
    by_slant_mm: FloatArray
    bend_mm: float


@dataclass(frozen=True, slots=True, eq=False)
class Gradient:
    """A linear function of the points' distances, and of how far the holder keeps the piece.

    Attributes
    ----------
    points
        Shape (N,), by the distance of each point out of the profile.
    slant_mm
        Shape (2,), mm/rad, by the piece's turns from where its holder should keep it.
    """

    points: FloatArray
    slant_mm: FloatArray


def told(name: str, certified_mm: float, gradient: Gradient, laid: LaidPoints) -> Dimension:
    """Return the dimension that a gradient tells, with what makes it uncertain."""
    by_point = gradient.points
    return Dimension(
        name=name,
        certified_mm=certified_mm,
        off_mm=float(by_point @ laid.outside_mm + gradient.slant_mm @ laid.slant_rad),
        noise_mm=float(np.linalg.norm(by_point * laid.sigma_mm)),
        by_sensor_mm=by_point @ laid.by_sensor_mm,
        by_slant_mm=gradient.slant_mm * laid.slant_sigma_rad,
        bend_mm=BEND_SHARE * abs(float(by_point @ laid.bend_mm)),
    )


def gradient_of(columns: FloatArray, wanted: FloatArray, laid: LaidPoints) -> Gradient | None:
    """Return the gradient of a combination of the columns' factors; None if it is not told.

    Parameters
    ----------
    columns
        Shape (N, K), effects on the distances; what they owe to the pose is taken off beside.
    wanted
        Shape (K,), the combination.
    laid
        The points.
    """
    columns = np.column_stack([columns, _rigid(laid)])
    wanted = np.concatenate([wanted, np.zeros(columns.shape[1] - len(wanted))])
    weight = 1.0 / laid.sigma_mm**2
    information = (columns.T * weight) @ columns + _kept_by_holder(laid, columns.shape[1])
    scale = np.sqrt(np.maximum(np.diag(information), 1e-12))
    values, vectors = np.linalg.eigh(information / np.outer(scale, scale))
    clear = values > _SINGULAR * values[-1]
    turned = vectors.T @ (wanted / scale)
    if not np.abs(turned[~clear]).max(initial=0.0) <= 1e-6 * np.linalg.norm(turned):
        return None
    solution = vectors[:, clear] @ (turned[clear] / values[clear]) / scale
    return Gradient(weight * (columns @ solution), solution[-2:] / laid.slant_sigma_rad**2)


def mean_gradients(laid: LaidPoints) -> Callable[[BoolArray], Gradient]:
    """Return what gives the gradient of the mean distance of some points, the piece laid rigidly.

    Which points: a mask, shape (N,).
    """
    rigid = _rigid(laid)
    weight = 1.0 / laid.sigma_mm**2
    normal = (rigid.T * weight) @ rigid + _kept_by_holder(laid, rigid.shape[1])
    scale = np.sqrt(np.maximum(np.diag(normal), 1e-12))
    inverse = np.linalg.pinv(normal / np.outer(scale, scale), rcond=_SINGULAR, hermitian=True)
    inverse /= np.outer(scale, scale)

    def gradient_of_mean(here: BoolArray) -> Gradient:
        mean = np.where(here, weight, 0.0) / weight[here].sum()
        # What the fit of the pose takes of each residual.
        taken = (mean @ rigid) @ inverse
        return Gradient(mean - weight * (rigid @ taken), -taken[-2:] / laid.slant_sigma_rad**2)

    return gradient_of_mean


def _rigid(laid: LaidPoints) -> FloatArray:
    """Return what motions of the piece do to the distances, shape (N, 5).

    Shifts, a turn per piece size, and slants, which its holder keeps small.
    """
    return np.column_stack([laid.normal, laid.turning_mm / laid.piece.size_mm, laid.slanting_mm])


def _kept_by_holder(laid: LaidPoints, count: int) -> FloatArray:
    """Return what the holder tells of the last two of some columns, as information."""
    information = np.zeros(count)
    information[-2:] = 1.0 / laid.slant_sigma_rad**2
    return np.diag(information)
