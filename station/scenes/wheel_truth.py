"""A worn wheel whose shape is known, and what the gauges truly read on it."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from calib import FloatArray, frozen
from measure import reference_profile

_STEP_MM = 0.05
_BACK_FACE_MM = 60.0
_FIELD_FACE_MM = 30.0
_BACK_Y_MM = -70.0
_TIP_Y_MM = -55.0


@dataclass(frozen=True, slots=True)
class TrueReadings:
    """What error-free gauges read on a profile, mm; the quantities are those of `measure`."""

    flange_height: float
    flange_thickness_10: float
    flange_thickness_12: float
    flange_gradient_qr: float
    tread_wear: float


@dataclass(frozen=True, slots=True, eq=False)
class WheelProfile:
    """The outline of a wheel's rim in one radial section, from the flange back to the field side.

    Attributes
    ----------
    points_mm
        Shape (N, 2): y lateral from the tape circle, z radially outward from the tread at the
        tape circle; down the flange back and the field face too.
    """

    points_mm: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "points_mm", frozen(self.points_mm, (None, 2), "points_mm"))

    @property
    def normals(self) -> FloatArray:
        """Outward unit normals (y, z), shape (N, 2)."""
        tangent = np.gradient(self.points_mm, axis=0)
        tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
        return np.column_stack([-tangent[:, 1], tangent[:, 0]])


@dataclass(frozen=True, slots=True)
class WheelTruth:
    """A wheel: which profile it had when new, and how it has worn.

    Attributes
    ----------
    reference
        Name of the profile it had: ``"S1002"`` or ``"LMA"``.
    tread_wear_mm
        Height lost at the tape circle. It is greatest near there and fades out towards the
        flange and the field side. The flange tip does not wear.
    flange_wear_mm
        How far the flange face has moved towards the flange back, on the middle of the face.
    radius_mm
        Radius at the tape circle, as it is now.

    Raises
    ------
    ValueError
        If a figure is out of the range in which the profile stays a wheel's.
    """

    reference: str = "S1002"
    tread_wear_mm: float = 0.0
    flange_wear_mm: float = 0.0
    radius_mm: float = 420.0

    def __post_init__(self) -> None:
        # Beyond these the worn face would overhang, or the flange's foot be lost.
        if not 0.0 <= self.tread_wear_mm <= 8.0:
            raise ValueError(f"tread_wear_mm {self.tread_wear_mm}; allowed: 0 to 8")
        if not 0.0 <= self.flange_wear_mm <= 6.0:
            raise ValueError(f"flange_wear_mm {self.flange_wear_mm}; allowed: 0 to 6")
        if not 200.0 <= self.radius_mm <= 700.0:
            raise ValueError(f"radius_mm {self.radius_mm}; allowed: 200 to 700")

    @property
    def profile(self) -> WheelProfile:
        """The worn outline; its height is counted from the worn tread at the tape circle."""
        return _worn_profile(self.reference, self.tread_wear_mm, self.flange_wear_mm)

    @property
    def readings(self) -> TrueReadings:
        """What the gauges truly read."""
        nominal = _read(_worn_profile(self.reference, 0.0, 0.0).points_mm, 0.0)
        return _read(self.profile.points_mm, nominal.flange_height)


@lru_cache(maxsize=64)
def _worn_profile(reference: str, tread_wear_mm: float, flange_wear_mm: float) -> WheelProfile:
    y, z = _new_outline(reference).T
    worn_y = y - flange_wear_mm * _face_share(y)
    worn_z = z - tread_wear_mm * _tread_share(y)
    worn_z -= np.interp(0.0, worn_y, worn_z)
    front = _evenly(np.column_stack([worn_y, worn_z]))
    down = np.arange(_STEP_MM, _BACK_FACE_MM, _STEP_MM)
    back = np.column_stack([np.full(len(down), front[0, 0]), front[0, 1] - down])[::-1]
    down = down[down < _FIELD_FACE_MM]
    field = np.column_stack([np.full(len(down), front[-1, 0]), front[-1, 1] - down])
    return WheelProfile(np.concatenate([back, front, field]))


def _new_outline(reference: str) -> FloatArray:
    """Return the reference from the flange back to the field side, shape (N, 2)."""
    return reference_profile(reference).points(_STEP_MM / 4.0)


def _face_share(y_mm: FloatArray) -> FloatArray:
    """Return the share of the flange wear that a place bears: 1 on the face, 0 on tip and tread."""
    return _rise(y_mm, -54.0, -40.0) * (1.0 - _rise(y_mm, -37.5, -25.0))


def _tread_share(y_mm: FloatArray) -> FloatArray:
    """Return the share of the tread wear that a place bears: 1 at the tape circle."""
    running_band = np.exp(-0.5 * (y_mm / 32.0) ** 4)
    # The field side hardly touches the rail, the flange's tip not at all.
    return np.asarray(running_band * _rise(y_mm, -52.0, -34.0) * (1.0 - _rise(y_mm, 35.0, 58.0)))


def _rise(y_mm: FloatArray, start_mm: float, end_mm: float) -> FloatArray:
    """Return a step from 0 to 1 with two smooth derivatives."""
    t = np.clip((y_mm - start_mm) / (end_mm - start_mm), 0.0, 1.0)
    return np.asarray(t**3 * (10.0 + t * (6.0 * t - 15.0)))


def _evenly(points_mm: FloatArray) -> FloatArray:
    """Return the same line with points a step apart."""
    steps = np.linalg.norm(np.diff(points_mm, axis=0), axis=1)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    along = np.linspace(0.0, length[-1], round(length[-1] / _STEP_MM) + 1)
    return np.column_stack([np.interp(along, length, column) for column in points_mm.T])


def _read(points_mm: FloatArray, nominal_height_mm: float) -> TrueReadings:
    """Read the gauges straight off a dense outline, by their definitions."""
    y, z = points_mm.T
    front = y > _BACK_Y_MM
    y, z = y[front], z[front]
    tip = int(np.argmax(z))
    tread_mm = float(np.interp(0.0, y, z))
    height_mm = float(z[tip]) - tread_mm
    face = slice(tip, int(np.searchsorted(y, 0.0)))

    def face_y_mm(z_mm: float) -> float:
        # The face falls from the tip to the tread; turned round, it rises as interp wants it.
        return float(np.interp(z_mm, z[face][::-1], y[face][::-1]))

    at_10_mm = face_y_mm(tread_mm + 10.0)
    return TrueReadings(
        flange_height=height_mm,
        flange_thickness_10=at_10_mm - _BACK_Y_MM,
        flange_thickness_12=face_y_mm(tread_mm + 12.0) - _BACK_Y_MM,
        flange_gradient_qr=at_10_mm - face_y_mm(float(z[tip]) - 2.0),
        tread_wear=height_mm - nominal_height_mm,
    )
