"""What results say of axles, and what a wheel's row keeps for it: where its flange back stood."""

from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from typing import Self

import numpy as np
from pydantic import AwareDatetime, Field

from calib import FloatArray
from measure import Alarm, Budget, Placing, Status, Survey, WheelPlace
from station.documents.base import Document

_DECIMALS = 4
"""To 0.1 um: a hundredth of what the best place of a flange back is doubted by."""
_EPOCH = datetime(1970, 1, 1, tzinfo=UTC)


class BackDocument(Document):
    """Where the flange back stood when one shot was taken, in the frame of its rig, mm."""

    time: AwareDatetime
    back_mm: float
    """Its rig y."""
    at_mm: tuple[float, float]
    """Rig (x, z) of where it was seen."""
    single_mm: float = Field(ge=0.0)
    """Standard deviation of `back_mm`, independent from shot to shot."""
    shared_mm: tuple[float, ...]
    """Its change for one sigma of each cause that the shots share, the same in each in order."""

    def place(self) -> WheelPlace:
        """Return it as what tells the distance of flange backs takes it."""
        return WheelPlace(
            time_ns=(self.time - _EPOCH) // timedelta(microseconds=1) * 1000,
            back_mm=self.back_mm,
            back=Budget(self.single_mm, np.array(self.shared_mm)),
            treads=(),
            back_at_mm=np.array(self.at_mm),
        )


class StandingDocument(Document):
    """How a wheel stood beside its rig: what its side gives to the back-to-back distance."""

    sigma_axle_direction_rad: float = Field(gt=0.0)
    """How well the axle's direction was known."""
    backs: tuple[BackDocument, ...]
    """One for each shot that saw the flange back."""

    @classmethod
    def of(cls, places: Sequence[WheelPlace], survey: Survey | None) -> Self | None:
        """Take over where a flange back was seen and when; None where nothing tells."""
        seen = [
            (place.time_ns, place.back_mm, place.back, place.back_at_mm)
            for place in places
            if place.time_ns is not None
            and place.back_mm is not None
            and place.back is not None
            and place.back_at_mm is not None
        ]
        if survey is None or not seen:
            return None
        shared = _folded(np.stack([back.shared_mm for _, _, back, _ in seen]))
        return cls(
            sigma_axle_direction_rad=survey.sigma_axle_direction_rad,
            backs=tuple(
                BackDocument(
                    time=_EPOCH + timedelta(microseconds=time_ns / 1000),
                    back_mm=round(back_mm, _DECIMALS),
                    at_mm=(round(at_mm[0], _DECIMALS), round(at_mm[1], _DECIMALS)),
                    single_mm=round(back.single_mm, _DECIMALS),
                    shared_mm=_rounded(row),
                )
                for (time_ns, back_mm, back, at_mm), row in zip(seen, shared, strict=True)
            ),
        )

    def places(self) -> list[WheelPlace]:
        """Return where the wheel stood."""
        return [back.place() for back in self.backs]


def _folded(shared_mm: FloatArray) -> FloatArray:
    """Return motions by as few causes as there are shots, with the same covariance.

    A rig of two sensors has some forty causes; of S, a row a shot, only S S^T counts, and with
    S^T = Q R that is R^T R.
    """
    return np.asarray(np.linalg.qr(shared_mm.T).R.T)


def _rounded(values: FloatArray) -> tuple[float, ...]:
    return tuple(np.round(values, _DECIMALS).tolist())


class BackToBackDocument(Document):
    """Distance between the flange backs of an axle, mm; null with a reason where not measured."""

    value: float | None = None
    u95: float | None = None
    status: Status
    alarm: Alarm
    pairs: int = 0
    """Shots of left and right at one time that it is the mean of."""
    reason: str | None = None
    """Why there is no value."""


class AxleDocument(Document):
    """One axle of a train."""

    axle: int | None
    """Its number in the train, from 1; null where that is not known."""
    placing: Placing
    back_to_back: BackToBackDocument
