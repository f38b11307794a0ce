"""How the steel of a wheel returns light: dust and rust all round, shine where it is polished."""

import numpy as np

from calib import FloatArray

_ROUGHNESS_EXPONENT = 10.0
# Along the profile (y, mm): the flange back is rusty, the tip greasy, the face dusty, the tread
# rolled bright. What is not returned to all sides is, on the tread, returned as shine.
_PLACES_MM = (-70.0, -66.0, -60.0, -50.0, -43.0, -34.0, -27.0, 33.0, 40.0)
_MATT = (0.95, 0.55, 0.3, 0.3, 0.85, 0.85, 0.25, 0.25, 0.45)
_SHINE = (0.05, 0.1, 0.2, 0.2, 0.1, 0.1, 0.55, 0.55, 0.1)


def dirt(rng: np.random.Generator, count: int, step_mm: float, grain: float) -> FloatArray:
    """Return how much a rim's places along its profile return, around 1.

    Parameters
    ----------
    rng
        Draws the dirt.
    count, step_mm
        Number and distance of the places.
    grain
        Standard deviation of the turning marks; the stains of some millimetres have as much.
    """
    length = count * step_mm
    places = np.arange(count) * step_mm
    field = np.ones(count)
    for size_mm in (0.6, 5.0):
        knots = np.arange(0.0, length + 2.0 * size_mm, size_mm)
        field += grain * np.interp(places, knots, rng.normal(size=len(knots)))
    return np.asarray(np.clip(field, 0.3, 1.7))


def returned(
    y_mm: FloatArray, normals: FloatArray, to_light: FloatArray, to_eye: FloatArray
) -> FloatArray:
    r"""Return the light that comes back from steel, per light that falls on it.

    Parameters
    ----------
    y_mm
        Lateral places on the profile, shape (...).
    normals, to_light, to_eye
        Unit vectors, shape (..., 3).

    Returns
    -------
    share
        Shape (...): 1 is a matt white surface.

    Notes
    -----
    :math:`k_d + k_s (n \cdot h)^{10}` with h halfway between light and eye: the blunt lobe of
    steel rolled on, not a mirror's.
    """
    halfway = to_light + to_eye
    halfway = halfway / np.linalg.norm(halfway, axis=-1, keepdims=True)
    lobe = np.maximum((normals * halfway).sum(axis=-1), 0.0) ** _ROUGHNESS_EXPONENT
    matt = np.interp(y_mm, _PLACES_MM, _MATT)
    return np.asarray(matt + np.interp(y_mm, _PLACES_MM, _SHINE) * lobe)
