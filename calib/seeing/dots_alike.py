"""What the dots of one picture have in common: from it each dot's shape is known beforehand."""

import numpy as np

from calib.arrays import BoolArray, FloatArray
from calib.seeing import disc
from calib.seeing.dots_soft import SOFT_FROM_PX
from calib.seeing.patch_fit import Prior

_EVENNESS = 0.05  # change of a dot's height over its radius, of the height
_SOFT = 0.3  # blur over radius: beyond, a smaller and brighter disc with more blur looks alike
_SOFT_EVENNESS = 0.0005  # a bell on a slope is a bell aside: one of the two has to be given up
_BLUR_KNOWN = 0.1  # of it
_CLIPPED_DOME = 0.0005
_FEWEST_FOR_A_PLANE, _FEWEST_FOR_A_BOWL = 8, 20
_LEAST_SHAPE, _LEAST_BLUR_PX, _LEAST_DOME = 0.002, 0.02, 0.01
_FARTHEST_SIGMAS = 3.0
_ROUNDS = 4
_SLOPES = [disc.HEIGHT_U, disc.HEIGHT_V]
_FORM = np.s_[:, disc.Q11 : disc.Q22 + 1]


def even_dots(parameters: FloatArray, radius_px: FloatArray, clipped: BoolArray) -> Prior:
    """Return that a dot is about as bright on one side as on the other, and in its middle.

    Of a soft dot the blur is taken for known: it cannot be told from size and height.
    What is clipped does not tell how bright it is, and a height that may rise to one side lets
    the outline move out on the other.

    Parameters
    ----------
    parameters
        Shape (N, disc.COUNT); only the heights are looked at.
    radius_px
        Shape (N,), about.
    clipped
        Shape (N,): dots whose inside is at the sensor's limit.
    """
    prior = Prior.nothing(parameters.shape)
    height = np.maximum(np.abs(parameters[:, disc.HEIGHT]), 1.0)
    blur = parameters[:, disc.BLUR]
    soft = (blur > _SOFT * radius_px) & (blur >= SOFT_FROM_PX)
    evenness = np.where(soft, _SOFT_EVENNESS, _EVENNESS)
    prior.precision[:, _SLOPES, _SLOPES] = ((radius_px / height / evenness) ** 2)[:, None]
    dome = np.where(clipped, _CLIPPED_DOME, evenness)
    prior.precision[:, disc.DOME, disc.DOME] = (radius_px**2 / height / dome) ** 2
    prior.mean[soft, disc.BLUR] = blur[soft]
    prior.precision[soft, disc.BLUR, disc.BLUR] = 1.0 / (_BLUR_KNOWN * blur[soft]) ** 2
    return prior


def alike(
    parameters: FloatArray,
    place_px: FloatArray,
    radius_px: FloatArray,
    usable: BoolArray,
    clipped: BoolArray,
) -> Prior:
    """Return what the others say of each dot's form, blur and dome.

    Parameters
    ----------
    parameters
        Shape (N, disc.COUNT), of a first fit.
    place_px
        Shape (N, 2), where the dots are.
    radius_px
        Shape (N,), about.
    usable, clipped
        Shape (N,): dots that tell; dots whose inside is at the sensor's limit.

    Returns
    -------
    Prior
        Where few dots are usable, no more than that dots are even.

    Notes
    -----
    Dots of one size on one plane, seen by one lens: size, flattening and blur change smoothly
    over the picture. How far the dots are off a smooth surface says how well it tells. Size
    and flattening stand apart, for clipping swells dots but leaves them round.
    """
    prior = even_dots(parameters, radius_px, clipped)
    if usable.sum() < _FEWEST_FOR_A_PLANE:
        return prior
    surface = _surface(place_px, usable)
    _form_alike(prior, parameters, surface, usable)
    prior.mean[:, disc.BLUR], sigma = _smooth(
        surface, parameters[:, disc.BLUR], usable, _LEAST_BLUR_PX
    )
    prior.precision[:, disc.BLUR, disc.BLUR] = 1.0 / sigma**2
    _dome_alike(prior, parameters, radius_px, usable & ~clipped)
    return prior


def _form_alike(
    prior: Prior, parameters: FloatArray, surface: FloatArray, usable: BoolArray
) -> None:
    q11, q12, q22 = parameters[_FORM].T
    scale = float(np.median(0.5 * (q11 + q22)[usable]))
    least = _LEAST_SHAPE * scale
    size, size_sigma = _smooth(surface, 0.5 * (q11 + q22), usable, least)
    first, first_sigma = _smooth(surface, 0.5 * (q11 - q22), usable, least)
    second, second_sigma = _smooth(surface, q12, usable, least)
    prior.mean[_FORM] = np.column_stack([size + first, second, size - first])
    a, b, c = 0.25 / size_sigma**2, 0.25 / first_sigma**2, 1.0 / second_sigma**2
    form = np.array([[a + b, 0.0, a - b], [0.0, c, 0.0], [a - b, 0.0, a + b]])
    prior.precision[:, disc.Q11 : disc.Q22 + 1, disc.Q11 : disc.Q22 + 1] = form


def _dome_alike(
    prior: Prior, parameters: FloatArray, radius_px: FloatArray, usable: BoolArray
) -> None:
    if usable.sum() < _FEWEST_FOR_A_PLANE:
        return
    height = parameters[:, disc.HEIGHT]
    height = np.where(np.abs(height) > 1.0, height, 1.0)
    unit = height / radius_px**2
    dome, sigma = _smooth(
        np.ones((len(unit), 1)), parameters[:, disc.DOME] / unit, usable, _LEAST_DOME
    )
    prior.mean[:, disc.DOME] = dome * unit
    prior.precision[:, disc.DOME, disc.DOME] = 1.0 / (sigma * unit) ** 2


def _surface(place_px: FloatArray, usable: BoolArray) -> FloatArray:
    """Return the terms of a smooth surface at each dot, shape (N, 3) or (N, 6)."""
    low, high = place_px[usable].min(axis=0), place_px[usable].max(axis=0)
    x, y = ((place_px - low) / np.maximum(high - low, 1.0) - 0.5).T
    terms = [np.ones_like(x), x, y]
    if usable.sum() >= _FEWEST_FOR_A_BOWL:
        terms += [x * x, x * y, y * y]
    return np.column_stack(terms)


def _smooth(
    surface: FloatArray, value: FloatArray, usable: BoolArray, least: float
) -> tuple[FloatArray, float]:
    """Return the surface through values, and the robust deviation of the usable ones from it."""
    keep, solution, sigma = usable, np.asarray(np.zeros(surface.shape[1])), np.inf
    for _ in range(_ROUNDS):
        solution = np.asarray(np.linalg.lstsq(surface[keep], value[keep], rcond=None)[0])
        off = np.abs(value - surface @ solution)
        sigma = max(float(np.median(off[usable])) / 0.6745, least)
        keep = usable & (off < _FARTHEST_SIGMAS * sigma)
    return np.asarray(surface @ solution), sigma
