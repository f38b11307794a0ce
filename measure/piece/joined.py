"""What several pictures of a piece tell of one dimension, together."""

from collections.abc import Sequence

import numpy as np

from calib import FloatArray
from measure.gauging.uncertainty import COVERAGE_FACTOR, MODEL_FLOOR_MM
from measure.piece.certified import Piece
from measure.piece.gradient import Dimension
from measure.piece.verdict import Told

# A piece that stood still shows the same speckle again: only where it was moved by more than
# grain and kernel do pictures scatter apart.
_MOVED_MM = 1.0
_PROFILE = "profile"


def placement_weights(corners_mm: Sequence[FloatArray]) -> list[tuple[int, float]]:
    """Return for each picture its placement, and the share it has in the mean.

    Parameters
    ----------
    corners_mm
        Where the piece's edges lay in each, all in one frame.
    """
    first: list[int] = []
    placement: list[int] = []
    for index, place in enumerate(corners_mm):
        still = [
            k for k, one in enumerate(first) if np.abs(place - corners_mm[one]).max() < _MOVED_MM
        ]
        placement.append(still[0] if still else len(first))
        first += [] if still else [index]
    return [(one, 1.0 / (len(first) * placement.count(one))) for one in placement]


def joined(
    parts: Sequence[Sequence[Dimension]],
    weights: Sequence[tuple[int, float]],
    covariance: FloatArray,
    piece: Piece,
    stretch_u95: float,
) -> list[Told]:
    """Join what pictures tell of each dimension: the noise of a placement is its own.

    Parameters
    ----------
    parts
        The dimensions that each picture tells.
    weights
        Of `placement_weights`.
    covariance
        Of the sensor's parameters, or of the rig's.
    piece, stretch_u95
        As it is now, and what is not known of its size, a part of it.
    """
    return [
        _joined(same, weights, covariance, piece.u95_mm, stretch_u95) for same in _by_name(parts)
    ]


def _by_name(parts: Sequence[Sequence[Dimension]]) -> list[list[Dimension | None]]:
    """Return each dimension in all pictures; None where a picture does not tell it."""
    tables = [{one.name: one for one in part} for part in parts]
    names = dict.fromkeys(one.name for part in parts for one in part)
    return [[table.get(name) for table in tables] for name in names]


def _joined(
    same: Sequence[Dimension | None],
    weights: Sequence[tuple[int, float]],
    covariance: FloatArray,
    certificate_u95_mm: float,
    stretch_u95: float,
) -> Told:
    told = [(one, *weight) for one, weight in zip(same, weights, strict=True) if one is not None]
    total = sum(share for _, _, share in told)
    noise: dict[int, float] = {}
    off = certified = bend = 0.0
    by_sensor, by_slant = np.zeros(len(covariance)), np.zeros(2)
    for one, placement, share in told:
        part = share / total
        off += part * one.off_mm
        certified += part * one.certified_mm
        bend += part * one.bend_mm
        by_sensor += part * one.by_sensor_mm
        # A holder that stands askew does so in every placement.
        by_slant += part * one.by_slant_mm
        noise[placement] = noise.get(placement, 0.0) + part * one.noise_mm
    variance = float(by_sensor @ covariance @ by_sensor) + float(by_slant @ by_slant)
    variance += bend**2 + MODEL_FLOOR_MM**2 + sum(part**2 for part in noise.values())
    # Along the profile the certified value is a place, which no stretch makes wrong.
    length = 0.0 if told[0][0].name.startswith(_PROFILE) else certified
    u95 = np.linalg.norm([
        COVERAGE_FACTOR * variance**0.5,
        certificate_u95_mm,
        stretch_u95 * length,
    ])
    return Told(told[0][0].name, certified, off, float(u95))
