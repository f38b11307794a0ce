"""What a sensor's pictures say in the calibration of its rig: a solve of their own to be ranked."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from station.documents import PoseDocument, RmsDocument
from station.page.calibration.pictures import rms
from station.report import PictureEvidence
from station.store import RigCalibrationPoints


@dataclass(frozen=True, slots=True)
class SolvedOnRig:
    """The pictures of one sensor of a rig, as what ranks them takes it."""

    rms: RmsDocument
    left_out: Mapping[str, str]
    poses: Sequence[PoseDocument] = ()
    warnings: Sequence[str] = ()

    @classmethod
    def of(cls, pictures: Sequence[PictureEvidence]) -> "SolvedOnRig":
        """Make it of the pictures' points, each of which says why its picture was left out."""
        dots = [each.dots.deviation_px[each.dots.used] for each in pictures]
        stripe = [each.stripe.deviation_px[each.stripe.used] for each in pictures]
        return cls(
            rms=RmsDocument(
                dots_px=_length_rms(dots),
                stripe_px=_length_rms(stripe),
            ),
            left_out={
                each.name: next(iter(each.dots.reason), "") or "not solved"
                for each in pictures
                if not each.solved
            },
        )


def _length_rms(parts: Sequence[np.ndarray]) -> float:
    lengths = np.linalg.norm(np.vstack([np.empty((0, 2)), *parts]), axis=1)
    return rms(lengths) if lengths.size else 0.0


def sensors_with_points(session: Session, calibration_id: str) -> Sequence[str]:
    """Return the sensors whose points a rig's calibration has kept, by name."""
    return session.scalars(
        select(RigCalibrationPoints.sensor)
        .where(RigCalibrationPoints.rig_calibration_id == calibration_id)
        .order_by(RigCalibrationPoints.sensor)
    ).all()
