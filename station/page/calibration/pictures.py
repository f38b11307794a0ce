"""What the pictures of a calibration are drawn of, as JSON: each one's points, residuals of all."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from calib import FloatArray
from station.operations import FramePlace
from station.report import (
    PictureEvidence,
    PointSet,
    RankedPicture,
    Solved,
    evidence_of,
    whitened_dots,
    whitened_stripe,
    worst_first,
)

_MOST_STRIPE_POINTS = 150
_MOST_NEEDLES = 1500
_REACH_SIGMA, _BINS = 4.0, 32
_Json = dict[str, Any]


def pictures_drawn(
    solved: Solved, pictures: Sequence[PictureEvidence], size_px: tuple[int, int]
) -> _Json:
    """Return the pictures, those that disagree most first, and the residuals of all."""
    return {
        "size_px": list(size_px),
        "pictures": [_summary(each) for each in worst_first(solved, pictures)],
        "field": {
            "dots": _needles([each.dots for each in pictures]),
            "stripe": _needles([each.stripe for each in pictures]),
        },
        "histograms": {
            "dots": _histogram(whitened_dots(pictures)),
            "stripe": _histogram(whitened_stripe(pictures)),
        },
    }


def picture_of(
    solved: Solved,
    size_px: tuple[int, int],
    points_csv: str,
    place: int,
    frames: Mapping[str, FramePlace],
) -> _Json | None:
    """Return one picture's points, by its place in the ranking; None where there is none."""
    ranked = worst_first(solved, evidence_of(points_csv))
    if not 0 <= place < len(ranked):
        return None
    evidence = ranked[place].evidence
    frame = frames.get(evidence.name)
    return {
        **_summary(ranked[place]),
        "frame": None if frame is None else {"recording": frame.recording, "number": frame.number},
        "size_px": list(size_px),
        "dots": _points(evidence.dots, 1),
        "stripe": _points(evidence.stripe, -(-len(evidence.stripe) // _MOST_STRIPE_POINTS) or 1),
    }


def _summary(ranked: RankedPicture) -> _Json:
    evidence = ranked.evidence
    return {
        "name": evidence.name,
        "left_out": ranked.left_out,
        "warnings": list(ranked.warnings),
        "distance_mm": told(ranked.distance_mm),
        "tilt_deg": told(ranked.tilt_deg),
        "dots_used": int(evidence.dots.used.sum()),
        "dots_of": len(evidence.dots),
        "dots_rms_px": told(evidence.dots.rms_px),
        "stripe_used": int(evidence.stripe.used.sum()),
        "stripe_of": len(evidence.stripe),
        "stripe_rms_px": told(evidence.stripe.rms_px),
        "unused": _unused(evidence),
    }


def _unused(evidence: PictureEvidence) -> list[list[Any]]:
    kinds = (("dots", evidence.dots), ("stripe", evidence.stripe))
    return [
        [kind, reason, count]
        for kind, points in kinds
        for reason, count in points.unused_by_reason.most_common()
    ]


def _points(points: PointSet, every: int) -> _Json:
    known = np.asarray(np.isfinite(points.corrected_px).all(axis=1))
    return {
        "seen_px": np.round(points.seen_px[::every], 3).tolist(),
        "corrected_px": [
            pair if told else None
            for pair, told in zip(
                np.round(points.corrected_px[::every], 3).tolist(),
                known[::every].tolist(),
                strict=True,
            )
        ],
        "used": points.used[::every].tolist(),
        "reason": list(points.reason[::every]),
    }


def _needles(sets: Sequence[PointSet]) -> _Json:
    """Return places and deviations of the points used, every n-th of many."""
    none = np.empty((0, 2))
    places = np.vstack([none, *(points.seen_px[points.used] for points in sets)])
    deviations = np.vstack([none, *(points.deviation_px[points.used] for points in sets)])
    every = -(-len(places) // _MOST_NEEDLES) or 1
    return {
        "every": every,
        "rms_px": told(rms(np.linalg.norm(deviations, axis=1))),
        "at_px": np.round(places[::every]).astype(int).tolist(),
        "by_px": np.round(deviations[::every], 3).tolist(),
    }


def _histogram(whitened: FloatArray) -> _Json:
    counts, edges = np.histogram(whitened, bins=_BINS, range=(-_REACH_SIGMA, _REACH_SIGMA))
    return {
        "counts": counts.tolist(),
        "edges": edges.tolist(),
        "points": int(whitened.size),
        "beyond": int(whitened.size - counts.sum()),
        "rms": told(rms(whitened)),
    }


def told(value: float, digits: int = 6) -> float | None:
    """Return a number as JSON has it: rounded, and null where it is none."""
    return round(value, digits) if math.isfinite(value) else None


def rms(values: FloatArray) -> float:
    """Return the root mean square; NaN of nothing."""
    return float(np.sqrt(np.mean(values**2))) if values.size else math.nan
