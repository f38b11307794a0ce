"""A measured profile taken apart for drawing: runs without gaps, bands, places of the gauges."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from calib import FloatArray, IntArray
from measure import EN_15313, GaugeLevels, Profile, Quantity, ReferenceProfile
from station.documents import ProfileDocument, WheelDocument

U95_SIGMAS = 1.96
_GAP_MM = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """A wheel as it is drawn.

    Attributes
    ----------
    points_mm
        Shape (N, 2), (d, h) in order.
    half_band_mm
        Shape (N,), half the 95 % band of each point's own scatter.
    wear_mm
        Shape (N,), NaN where there is none.
    tip_mm
        (d, h) of the flange tip.
    levels
        Where the gauges touch.
    seen_by
        Shape (N,), bits of the sensors of a rig that saw each point; None where one saw all.
    """

    points_mm: FloatArray
    half_band_mm: FloatArray
    wear_mm: FloatArray
    tip_mm: tuple[float, float]
    levels: GaugeLevels
    seen_by: IntArray | None = None

    @classmethod
    def of(
        cls,
        wheel: WheelDocument,
        profile: ProfileDocument,
        reference: ReferenceProfile | None,
        lowest_mm: float,
    ) -> "Drawn":
        """Take a measured wheel apart; what lies below the lowest height shown is left out.

        Without a reference, as where its file is gone, no wear is known.
        """
        measured = profile.profile()
        # The back face may reach far below the drawing.
        seen = measured.h_mm >= lowest_mm
        highest = int(np.argmax(measured.h_mm))
        said = wheel.header.levels_mm if wheel.header is not None else {}
        return cls(
            points_mm=measured.points_mm[seen],
            half_band_mm=U95_SIGMAS * measured.sigma_mm[seen],
            wear_mm=_wear_mm(measured, reference)[seen],
            tip_mm=(
                float(measured.d_mm[highest]),
                # The profile is aligned there: its highest point alone carries its own noise.
                float(measured.h_mm[highest])
                if reference is None
                else reference.nominal[Quantity.FLANGE_HEIGHT],
            ),
            seen_by=None if measured.seen_by is None else measured.seen_by[seen],
            levels=GaugeLevels(
                tape_d_mm=said.get("L2", EN_15313.tape_d_mm),
                face_mm=said.get("L3", EN_15313.face_mm),
                below_tip_mm=said.get("L1", EN_15313.below_tip_mm),
            ),
        )

    def runs(self) -> Iterator[slice]:
        """Yield the pieces between gaps, of two points or more."""
        steps = np.linalg.norm(np.diff(self.points_mm, axis=0), axis=1)
        ends = [0, *(np.flatnonzero(steps > _GAP_MM) + 1).tolist(), len(self.points_mm)]
        for first, last in zip(ends, ends[1:], strict=False):
            if last - first >= 2:
                yield slice(first, last)

    def strands(self, run: slice) -> Iterator[tuple[int, slice]]:
        """Yield the pieces of a run that the same sensors saw, with their bits; 0: one saw all.

        Each goes on to the first point of the next, so that the line has no gap.
        """
        if self.seen_by is None:
            yield 0, run
            return
        bits = self.seen_by[run]
        ends = [0, *(np.flatnonzero(np.diff(bits)) + 1).tolist(), len(bits)]
        for first, last in zip(ends, ends[1:], strict=False):
            yield int(bits[first]), slice(run.start + first, min(run.start + last + 1, run.stop))

    def lost(self, run: slice) -> FloatArray | None:
        """Return the outline of what is worn off along a run; None where nothing tells it."""
        known = np.isfinite(self.wear_mm[run])
        points, wear = self.points_mm[run][known], self.wear_mm[run][known]
        if len(points) < 2:
            return None
        # Where metal stands above the reference nothing is worn off.
        above = points + np.column_stack([np.zeros(len(wear)), np.maximum(wear, 0.0)])
        return np.concatenate([points, above[::-1]])

    def band(self, run: slice) -> FloatArray:
        """Return the outline of the 95 % band about a run."""
        points, half = self.points_mm[run], self.half_band_mm[run, None]
        tangent = np.gradient(points, axis=0)
        length = np.maximum(np.linalg.norm(tangent, axis=1), 1e-9)
        normal = tangent[:, ::-1] * [-1.0, 1.0] / length[:, None]
        return np.concatenate([points + half * normal, (points - half * normal)[::-1]])


def _wear_mm(measured: Profile, reference: ReferenceProfile | None) -> FloatArray:
    if reference is None:
        return np.full(len(measured.d_mm), np.nan)
    return measured.wear_mm(reference)
