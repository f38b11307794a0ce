"""Reference profiles: what a wheel looks like when new, and its nominal readings."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq, minimize_scalar

from calib import FloatArray
from measure.errors import ReferenceInvalid
from measure.quantities import Quantity
from measure.segments import Chords, Segment

BACK_Y_MM = -70.0
"""Lateral place of the flange back; the tape circle is at 0."""
_BELONGS_MM = 0.1
_COUNTED_FROM_IT = (Quantity.TREAD_WEAR, Quantity.TREAD_WEAR_AT_70, Quantity.TREAD_WEAR_MAX)


@dataclass(frozen=True, slots=True, eq=False)
class ReferenceProfile:
    """A wheel profile as designed: y lateral from the tape circle, z radially outward, mm.

    Attributes
    ----------
    name
        What it is called in results.
    segments
        Its pieces from the flange back to the field side.
    nominal
        What the gauges read on it, mm: flange height, thicknesses and gradient.
    height_sigma_mm
        Standard deviation of its heights below its tip; zero of a drawing.
    """

    name: str
    segments: tuple[Segment, ...]
    nominal: Mapping[Quantity, float]
    height_sigma_mm: float = 0.0

    def __post_init__(self) -> None:
        if not self.height_sigma_mm >= 0.0:
            raise ReferenceInvalid(f"{self.name}: a sigma of {self.height_sigma_mm} mm; 0 or more")

    @classmethod
    def from_segments(cls, name: str, segments: tuple[Segment, ...]) -> "ReferenceProfile":
        """Make a reference of pieces that start at the flange back.

        Raises
        ------
        ReferenceInvalid
            If the pieces have no flange above a tread that reaches the tape circle.
        """
        bare = cls(name, segments, MappingProxyType({}))
        return cls(name, segments, MappingProxyType(_nominal_readings(bare)))

    @classmethod
    def from_points(cls, name: str, y_mm: ArrayLike, z_mm: ArrayLike) -> "ReferenceProfile":
        """Make a reference of points: a table, or a new wheel that was measured.

        Parameters
        ----------
        name
            What it is called in results.
        y_mm, z_mm
            Shape (N,), in profile coordinates, in any order; of the back face (y <= -70) the
            uppermost point counts. The height at the tape circle becomes zero.

        Raises
        ------
        ReferenceInvalid
            If the points do not reach from the flange back over the tape circle.
        """
        y, z = np.asarray(y_mm, dtype=np.float64), np.asarray(z_mm, dtype=np.float64)
        if not (y.ndim == 1 and y.shape == z.shape and np.isfinite([y, z]).all()):
            raise ReferenceInvalid(f"{name}: y and z must be equally many finite numbers")
        y, z = _front(y, z)
        if not (len(y) >= 50 and y[0] <= BACK_Y_MM + 5.0 and y[-1] >= 10.0):
            seen = f"{len(y)} points, y {y[0]:.1f} to {y[-1]:.1f}" if len(y) else "no points"
            raise ReferenceInvalid(
                f"{name}: {seen} ahead of the flange back; a reference needs 50 or more "
                "from y = -65 or less to 10 or more"
            )
        return cls.from_segments(name, (Chords(y, z - np.interp(0.0, y, z)),))

    @classmethod
    def measured(
        cls,
        name: str,
        points_mm: FloatArray,
        nominal: Mapping[Quantity, float],
        height_sigma_mm: float,
    ) -> "ReferenceProfile":
        """Make a reference of a new wheel that was measured, with what the gauges read on it.

        Parameters
        ----------
        name
            What it is called in results.
        points_mm
            Shape (N, 2), (y, z), smoothed.
        nominal
            The gauges' own readings, mm: taken off the points once more they would carry the
            points' noise a second time.
        height_sigma_mm
            Standard deviation of the heights below the tip.

        Raises
        ------
        ReferenceInvalid
            If the points make no reference, or do not belong to the readings.
        """
        shape = cls.from_points(name, *points_mm.T)
        for quantity, read_mm in shape.nominal.items():
            if not abs(nominal.get(quantity, np.nan) - read_mm) <= _BELONGS_MM:
                raise ReferenceInvalid(
                    f"{name}: {quantity.value} of the points is {read_mm:.3f} mm, stated "
                    f"{nominal.get(quantity)}; points and readings must be of one wheel"
                )
        return cls(name, shape.segments, MappingProxyType(dict(nominal)), height_sigma_mm)

    def sigma_mm(self, quantity: Quantity) -> float:
        """Return what a reading owes to the reference itself: only wear is counted from it."""
        return self.height_sigma_mm if quantity in _COUNTED_FROM_IT else 0.0

    @property
    def start_mm(self) -> float:
        """Lateral place where it starts, next to the flange back."""
        first = self.segments[0]
        return float(first.y_mm[0]) if isinstance(first, Chords) else BACK_Y_MM

    @property
    def end_mm(self) -> float:
        """Lateral place where it ends, on the field side."""
        return self.segments[-1].end_mm

    def height_mm(self, y_mm: ArrayLike) -> FloatArray:
        """Return the height z at lateral places.

        Parameters
        ----------
        y_mm
            Any shape.

        Returns
        -------
        z_mm
            The same shape; NaN outside the profile.

        Examples
        --------
        >>> from measure import reference_profile
        >>> reference_profile("S1002").height_mm([0.0, -55.0, 99.0]).round(3).tolist()
        [0.0, 28.0, nan]
        """
        y = np.asarray(y_mm, dtype=np.float64)
        height = np.full(y.shape, np.nan)
        start = self.start_mm
        for segment in self.segments:
            inside = (y >= start) & (y <= segment.end_mm)
            height[inside] = segment.height_mm(y[inside])
            start = segment.end_mm
        return height

    def points(self, step_mm: float, *, back_face_mm: float = 0.0) -> FloatArray:
        """Return points (y, z) evenly along the profile, from the flange back to the field side.

        Parameters
        ----------
        step_mm
            Distance of neighbours along the profile, nearly.
        back_face_mm
            How much of the flange back, the straight face at y = -70, to put before it.

        Returns
        -------
        points_mm
            Shape (N, 2).
        """
        # Cosine spacing: the profile leaves the flange back at a right angle to y.
        span = self.end_mm - self.start_mm
        y = self.start_mm + span * (1.0 - np.cos(np.linspace(0.0, np.pi, 20_000))) / 2.0
        z = self.height_mm(y)
        length = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(y), np.diff(z)))])
        along = np.linspace(0.0, length[-1], max(2, round(length[-1] / step_mm) + 1))
        y_even = np.interp(along, length, y)
        front = np.column_stack([y_even, self.height_mm(y_even)])
        drops = np.arange(round(back_face_mm / step_mm), 0, -1) * step_mm
        back = np.column_stack([np.full(len(drops), front[0, 0]), front[0, 1] - drops])
        return np.concatenate([back, front])


def _front(y_mm: FloatArray, z_mm: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the points with rising y, from the flange back on, one height for each place.

    The flange back itself is upright: where its points scatter about y = -70 they would make
    heights that jump. From the tip down, each point that lies nearer to the back is taken, until
    one is on it.
    """
    if not len(y_mm):
        return y_mm, z_mm
    tip = int(np.argmax(z_mm))
    down = np.flatnonzero(y_mm < y_mm[tip])
    down = down[np.argsort(-z_mm[down], kind="stable")]
    before = np.minimum.accumulate(np.concatenate([[y_mm[tip]], y_mm[down]]))[:-1]
    nearer = (y_mm[down] < before) & (before > BACK_Y_MM)
    flange = down[nearer][::-1]
    rest = np.flatnonzero(y_mm >= y_mm[tip])
    rest = rest[np.unique(y_mm[rest], return_index=True)[1]]
    order = np.concatenate([flange, rest])
    y, z = y_mm[order], z_mm[order]
    # The point on the back ends the profile at y = -70 exactly, where the back face begins.
    return np.maximum(y, BACK_Y_MM), z


def _nominal_readings(profile: ReferenceProfile) -> dict[Quantity, float]:
    def height(y_mm: float) -> float:
        return float(profile.height_mm(y_mm))

    coarse = profile.points(0.1)
    if not (profile.start_mm < BACK_Y_MM + 6.0 and profile.end_mm > 0.0):
        raise ReferenceInvalid(f"{profile.name}: must reach from the flange back over y = 0")
    peak = coarse[np.argmax(coarse[:, 1]), 0]
    crest = minimize_scalar(
        lambda y: -height(y),
        bounds=(max(peak - 0.2, profile.start_mm), peak + 0.2),
        method="bounded",
        options={"xatol": 1e-9},
    )
    tip, tread = -float(crest.fun), height(0.0)
    if not (tip - tread > 14.0 and peak < -30.0):
        raise ReferenceInvalid(
            f"{profile.name}: the highest point is {tip - tread:.1f} mm above the tape circle at "
            f"y = {peak:.1f}; a flange of more than 14 mm left of y = -30 is needed"
        )

    def face(level_mm: float) -> float:
        return float(brentq(lambda y: height(y) - level_mm, crest.x, 0.0, xtol=1e-10))

    return {
        Quantity.FLANGE_HEIGHT: tip - tread,
        Quantity.FLANGE_THICKNESS_10: face(tread + 10.0) - BACK_Y_MM,
        Quantity.FLANGE_THICKNESS_12: face(tread + 12.0) - BACK_Y_MM,
        Quantity.FLANGE_GRADIENT_QR: face(tread + 10.0) - face(tip - 2.0),
    }
