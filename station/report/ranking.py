"""Which pictures disagree most with the answer."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from calib import RigidTransform
from station.documents import PoseDocument, RmsDocument
from station.report.evidence import PictureEvidence


class Solved(Protocol):
    """What a ranking needs of a calibration; a `CalibrationDocument` says it, as others may."""

    @property
    def rms(self) -> RmsDocument:
        """Over all pictures."""

    @property
    def poses(self) -> Sequence[PoseDocument]:
        """Of the pictures used, where they are kept."""

    @property
    def left_out(self) -> Mapping[str, str]:
        """Why pictures were left out, by name."""

    @property
    def warnings(self) -> Sequence[str]:
        """What is to be known; what is of one picture begins with its name."""


@dataclass(frozen=True, slots=True)
class RankedPicture:
    """One picture, where its target stood, and how much it disagrees.

    Attributes
    ----------
    evidence
        Its points.
    distance_mm, tilt_deg
        Of the target's first point from the camera, and of the target's normal from the ray to it;
        NaN where the picture was left out, or its pose is not kept.
    disagreement
        The larger of its RMS of target points and of stripe points, each over that of all
        pictures; infinite where the picture was left out.
    left_out
        Why the whole picture was left out; empty where it was used.
    warnings
        What the calibration says of this picture, without its name.
    """

    evidence: PictureEvidence
    distance_mm: float
    tilt_deg: float
    disagreement: float
    left_out: str
    warnings: tuple[str, ...]

    @property
    def order(self) -> tuple[bool, float]:
        """Sort key: a picture whose stripe was seen and not believed before all that fit."""
        stripe = self.evidence.stripe
        return not (len(stripe) and not stripe.used.any()), -self.disagreement


def worst_first(document: Solved, pictures: Sequence[PictureEvidence]) -> tuple[RankedPicture, ...]:
    """Rank the pictures: those left out, those whose stripe was not used, then by RMS."""
    poses = {pose.image: pose for pose in document.poses}
    ranked = [_rank(document, picture, poses.get(picture.name)) for picture in pictures]
    return tuple(sorted(ranked, key=lambda each: (not each.left_out, *each.order)))


def _rank(document: Solved, picture: PictureEvidence, pose: PoseDocument | None) -> RankedPicture:
    if not picture.solved:
        reason = reason_without_name(document, picture.name)
        return RankedPicture(picture, math.nan, math.nan, math.inf, reason, ())
    distance_mm, tilt_deg = _stand(pose) if pose is not None else (math.nan, math.nan)
    disagreement = _disagreement(document, picture)
    mine = f"{picture.name}: "
    said = tuple(w.removeprefix(mine) for w in document.warnings if w.startswith(mine))
    return RankedPicture(picture, distance_mm, tilt_deg, disagreement, "", said)


def reason_without_name(document: Solved, name: str) -> str:
    """Return why a picture was left out, without its name before it."""
    return document.left_out.get(name, "not solved").removeprefix(f"{name}: ")


def _stand(pose: PoseDocument) -> tuple[float, float]:
    cam_from_board = RigidTransform.from_rotation_vector(pose.rotation_vector, pose.translation_mm)
    distance_mm = float(np.linalg.norm(cam_from_board.translation_mm))
    away = cam_from_board.rotation[:, 2] @ cam_from_board.translation_mm / distance_mm
    return distance_mm, math.degrees(math.acos(min(1.0, abs(float(away)))))


def _disagreement(document: Solved, picture: PictureEvidence) -> float:
    parts = (
        picture.dots.rms_px / document.rms.dots_px if document.rms.dots_px > 0.0 else 0.0,
        picture.stripe.rms_px / document.rms.stripe_px if document.rms.stripe_px > 0.0 else 0.0,
    )
    # A picture without used points of a kind has no figure for it: NaN.
    return max((part for part in parts if math.isfinite(part)), default=0.0)
