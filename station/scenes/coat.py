"""What lies on the steel of a rim: dirt that hides it, lumps that stand on it, rust, grease."""

from dataclasses import dataclass

import numpy as np

from calib import FloatArray, frozen

_BACK_Y_MM, _FIELD_Y_MM = -68.0, 55.0
_EDGE_MM = 0.3  # an edge of rust or grease is no sharper than the rubbing that made it


@dataclass(frozen=True, slots=True)
class Soiling:
    """How dirty a rim is; a clean one is all zeros.

    Attributes
    ----------
    gaps
        Number of dull black patches, 1.5 to 5 mm of profile each, that send next to nothing back.
    lumps
        Number of lumps of dirt, 0.3 to 1.2 mm high and 1.5 to 4 mm wide.
    grease
        Share of the light that a film of grease takes from the flange face and the throat.
    rust
        By how much brighter the rusty field side of the tread is than its rolled band, in parts;
        the band ends at an edge.
    burnish
        By how much brighter the rolled band returns the laser than it should, in parts: a wheel
        rolled to a shine, which clips where its back face is nearly dark.

    Raises
    ------
    ValueError
        If a number or a share is out of range.
    """

    gaps: int = 0
    lumps: int = 0
    grease: float = 0.0
    rust: float = 0.0
    burnish: float = 0.0

    def __post_init__(self) -> None:
        if not (0 <= self.gaps <= 12 and 0 <= self.lumps <= 12):
            raise ValueError(f"gaps and lumps: 0 to 12 each, got {self.gaps} and {self.lumps}")
        if not 0.0 <= self.grease < 1.0:
            raise ValueError(f"grease must be from 0 to below 1, got {self.grease}")
        if not (0.0 <= self.rust < np.inf and 0.0 <= self.burnish < np.inf):
            raise ValueError(
                f"rust and burnish must not be negative, got {self.rust} and {self.burnish}"
            )

    def coat(self, points_mm: FloatArray, rng: np.random.Generator) -> "Coat":
        """Spread it over a profile, shape (N, 2); `rng` draws where it lies."""
        y, z = points_mm.T
        front = (y > -69.99) & (y < y.max())
        returns = np.ones(len(y))
        returns *= 1.0 - self.grease * _between(y, -46.0, -25.0) * front
        returns *= 1.0 + self.rust * _between(y, rng.uniform(28.0, 40.0), 200.0) * front
        returns *= 1.0 + self.burnish * _between(y, -24.0, rng.uniform(26.0, 40.0)) * front
        height = np.zeros(len(y))
        along = _along_mm(points_mm)
        for _ in range(self.gaps):
            middle, width = _place(y, along, rng), rng.uniform(1.5, 5.0)
            returns *= 1.0 - 0.98 * _between(along, middle - width / 2.0, middle + width / 2.0)
        for _ in range(self.lumps):
            middle, sigma = _place(y, along, rng), rng.uniform(1.5, 4.0) / 4.0
            height += rng.uniform(0.3, 1.2) * np.exp(-0.5 * ((along - middle) / sigma) ** 2)
        return Coat(returns, height)


@dataclass(frozen=True, slots=True, eq=False)
class Coat:
    """A layer on a profile of N points.

    Attributes
    ----------
    returns
        Shape (N,): factor on the light that comes back.
    height_mm
        Shape (N,): how far its surface stands off the steel.
    """

    returns: FloatArray
    height_mm: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "returns", frozen(self.returns, (None,), "returns"))
        object.__setattr__(
            self, "height_mm", frozen(self.height_mm, self.returns.shape, "height_mm")
        )


def _between(place_mm: FloatArray, start_mm: float, end_mm: float) -> FloatArray:
    """Return 1 between two places and 0 beyond, with soft edges."""
    rise = 0.5 * (1.0 + np.tanh((place_mm - start_mm) / _EDGE_MM))
    fall = 0.5 * (1.0 - np.tanh((place_mm - end_mm) / _EDGE_MM))
    return np.asarray(rise * fall)


def _along_mm(points_mm: FloatArray) -> FloatArray:
    steps = np.linalg.norm(np.diff(points_mm, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _place(y_mm: FloatArray, along_mm: FloatArray, rng: np.random.Generator) -> float:
    """Draw a place on the running surface, even along the profile."""
    front = along_mm[(y_mm > _BACK_Y_MM) & (y_mm < _FIELD_Y_MM)]
    return float(rng.uniform(front[0], front[-1]))
