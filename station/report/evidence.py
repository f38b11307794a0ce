"""Every point of a calibration, picture by picture, as points.csv has kept them."""

import csv
import io
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib import BoolArray, FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class PointSet:
    """The dots, or the stripe points, of one picture.

    Attributes
    ----------
    seen_px, corrected_px
        Shape (N, 2); corrected is NaN where the picture was left out.
    sigma_px
        Shape (N, 2), along u and v.
    used
        Shape (N,), the point took part in the answer.
    reason
        N entries: why a point is doubtful or was not used.
    """

    seen_px: FloatArray
    corrected_px: FloatArray
    sigma_px: FloatArray
    used: BoolArray
    reason: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.reason)

    @property
    def deviation_px(self) -> FloatArray:
        """Observed - corrected, shape (N, 2)."""
        return self.seen_px - self.corrected_px

    @property
    def rms_px(self) -> float:
        """Root mean square length of the deviations of the used points; NaN without one."""
        return rms(np.linalg.norm(self.deviation_px[self.used], axis=1))

    @property
    def unused_by_reason(self) -> Counter[str]:
        """How many points were not used, by cause."""
        pairs = zip(self.reason, self.used, strict=True)
        return Counter(reason or "not named" for reason, used in pairs if not used)


@dataclass(frozen=True, slots=True)
class PictureEvidence:
    """What was seen in one picture and what became of it."""

    name: str
    dots: PointSet
    stripe: PointSet

    @property
    def solved(self) -> bool:
        """Whether the picture took part in the answer."""
        corrected_px = np.vstack([self.dots.corrected_px, self.stripe.corrected_px])
        return bool(np.isfinite(corrected_px).any())

    @property
    def seen_px(self) -> FloatArray:
        """All points seen, shape (N, 2)."""
        return np.vstack([self.dots.seen_px, self.stripe.seen_px])


def rms(values: FloatArray) -> float:
    """Root mean square; NaN of nothing."""
    return float(np.sqrt(np.mean(values**2))) if values.size else float("nan")


def evidence_of(points_csv: str) -> tuple[PictureEvidence, ...]:
    """Read the text of points.csv, in its order.

    A picture's rows are its dots, then its stripe: where a dot follows a stripe, the next picture
    begins, even if it bears the same name.
    """
    blocks: list[list[dict[str, str]]] = []
    last: tuple[str, str] | None = None
    for row in csv.DictReader(io.StringIO(points_csv)):
        place = (row["image"], row["kind"])
        if last is None or last[0] != place[0] or (last[1], place[1]) == ("stripe", "dot"):
            blocks.append([])
        blocks[-1].append(row)
        last = place
    return tuple(_picture(rows) for rows in blocks)


def _picture(rows: Sequence[dict[str, str]]) -> PictureEvidence:
    return PictureEvidence(
        name=rows[0]["image"],
        dots=_points([row for row in rows if row["kind"] == "dot"]),
        stripe=_points([row for row in rows if row["kind"] == "stripe"]),
    )


def _points(rows: Sequence[dict[str, str]]) -> PointSet:
    return PointSet(
        seen_px=_pairs(rows, "u", "v"),
        corrected_px=_pairs(rows, "u_corrected", "v_corrected"),
        sigma_px=_pairs(rows, "sigma_u", "sigma_v"),
        used=np.array([row["used"] == "1" for row in rows], dtype=bool),
        reason=tuple(row["reason"] for row in rows),
    )


def _pairs(rows: Sequence[dict[str, str]], u: str, v: str) -> FloatArray:
    # An empty field is a number that there is not.
    pairs = [(float(row[u] or "nan"), float(row[v] or "nan")) for row in rows]
    return np.array(pairs, dtype=np.float64).reshape(-1, 2)


def whitened_dots(pictures: Sequence[PictureEvidence]) -> FloatArray:
    """Deviations of the used dots over their sigmas, u and v one after the other."""
    parts = [(p.dots.deviation_px / p.dots.sigma_px)[p.dots.used] for p in pictures]
    return np.vstack([np.empty((0, 2)), *parts]).ravel()


def whitened_stripe(pictures: Sequence[PictureEvidence]) -> FloatArray:
    """Deviations of the used stripe points along their normals over their sigmas.

    Positive is down the picture, or to the right where the stripe runs down it.
    """
    return np.concatenate([np.empty(0), *(_whitened(p.stripe) for p in pictures)])


def _whitened(stripe: PointSet) -> FloatArray:
    deviation_px, sigma_px = stripe.deviation_px[stripe.used], stripe.sigma_px[stripe.used]
    if not len(deviation_px):
        return np.empty(0)
    # Points move along the normal only, so the larger part of a deviation tells its sign.
    main = int(np.argmax(np.square(deviation_px).sum(axis=0)))
    length = np.linalg.norm(deviation_px, axis=1) / np.linalg.norm(sigma_px, axis=1)
    return np.asarray(np.copysign(length, deviation_px[:, main]))
