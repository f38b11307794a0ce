"""From deviations of a piece's dimensions to whether the sensor tells the truth."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Literal

from scipy.special import ndtri

from measure.gauging.uncertainty import COVERAGE_FACTOR
from measure.piece.place import PiecePlace

FALSE_ALARM = 0.01
"""How often a true sensor is called drifted, at most."""
COARSEST_U95_MM = 0.1
"""Without a limit, what is known less well than this says nothing of a wheel's readings."""
WELCOME = {
    "size": "the piece is too small, or too little of it is seen, to tell the scale",
    "angle": "a side is too short to tell its angle",
    "radius": "too little of a round side is seen to tell its radius",
    "place": "the piece slides along itself unseen, and its place is no witness",
    "turn": "the piece is too short to tell a turn",
    "twist": "the piece is too small to tell a twist of one sensor about its length",
}
"""Kinds of dimension that are judged only where they are told well, and what it means if not."""
_OF_THE_HOLDER = ("place", "turn")


class PieceVerdict(StrEnum):
    """What a check comes to."""

    TRUE = "tells the truth"
    DRIFTED = "drifted"
    UNKNOWN = "cannot say"


@dataclass(frozen=True, slots=True)
class PieceDeviation:
    """One dimension of the piece against its certificate.

    Attributes
    ----------
    name
        Which dimension: sides and corners are counted from 1, left to right.
    certified_mm, found_mm
        What it is, and what the sensor measures.
    u95_mm
        Expanded uncertainty of their difference: sensor, points, certificate, warmth and slant.
    verdict
        What it says alone.
    """

    name: str
    certified_mm: float
    found_mm: float
    u95_mm: float
    verdict: PieceVerdict

    @property
    def off_mm(self) -> float:
        """Found less certified."""
        return self.found_mm - self.certified_mm


@dataclass(frozen=True, slots=True)
class PieceReading:
    """One picture of the piece.

    Attributes
    ----------
    name
        Of the picture.
    points, rms_mm
        How many lie on the piece away from its edges, and their distance from its profile.
    place
        Where it lies on the sheet; None where it could not be read.
    reason
        Why nothing could be read; empty where something could.
    sensor
        Which of a rig's sensors took it; empty of one alone.
    """

    name: str
    points: int = 0
    rms_mm: float = float("nan")
    place: PiecePlace | None = None
    reason: str = ""
    sensor: str = ""


@dataclass(frozen=True, slots=True)
class PiecePower:
    """The least drift of one kind that would be found in 95 % of such checks.

    Attributes
    ----------
    name
        What drifts, as the deviation that shows it is named.
    found_from
        How far, in the unit.
    unit
        Of it.
    """

    name: str
    found_from: float
    unit: Literal["mm", "rad"]


@dataclass(frozen=True, slots=True)
class PieceJudgement:
    """What pictures of a piece say of the sensor.

    Attributes
    ----------
    verdict, reason
        What it comes to, and why in one line.
    deviations
        Dimensions: heights, widths, radii, size.
    profile
        Parts of the profile: place along it as the certified value, as found that and the
        distance from it.
    coverage_factor
        What u95 is multiplied by, as the largest of so many deviations is judged.
    readings
        Every picture.
    notes
        What could not be told, and is not needed for the verdict.
    powers
        Of a rig: which drifts of its sensors against each other would be found.
    """

    verdict: PieceVerdict
    reason: str
    deviations: tuple[PieceDeviation, ...]
    profile: tuple[PieceDeviation, ...]
    coverage_factor: float
    readings: tuple[PieceReading, ...]
    notes: tuple[str, ...] = ()
    powers: tuple[PiecePower, ...] = ()

    def with_powers(self, powers: Sequence[PiecePower]) -> "PieceJudgement":
        """Return the same judgement with the drifts that it would have found."""
        return replace(self, powers=tuple(powers))


@dataclass(frozen=True, slots=True)
class Told:
    """A dimension by all pictures, not judged yet."""

    name: str
    certified_mm: float
    off_mm: float
    u95_mm: float

    @property
    def kind(self) -> str:
        """What kind of dimension it is: the first word of its name."""
        return self.name.split(" ", 1)[0]


def judged_by(
    dimensions: Sequence[Told],
    form: Sequence[Told],
    hidden: Sequence[int],
    readings: Sequence[PieceReading],
    limit_mm: float | None,
    notes: Sequence[str],
) -> PieceJudgement:
    """Judge the deviations, and say what they come to together.

    Parameters
    ----------
    dimensions
        Those of `WELCOME` are judged where they are known well enough, all others are needed.
    form
        Parts of the profile: one may tell of a drift, none is needed.
    hidden
        Sides that ought to be seen and are not.
    readings, limit_mm, notes
        As for `PieceJudgement` and `judge_piece`.
    """
    coarsest = COARSEST_U95_MM if limit_mm is None else limit_mm
    untold = [one for one in dimensions if one.kind in WELCOME and not one.u95_mm <= coarsest]
    needed = [one for one in dimensions if one not in untold]
    notes = (
        *notes,
        *(f"{WELCOME[one.kind]}: {one.name} is known to {one.u95_mm:.3f} mm" for one in untold),
    )
    factor = _coverage_factor(len(needed) + len(form))
    deviations = tuple(_deviation(one, factor, limit_mm) for one in needed)
    profile = tuple(_part(one, factor, limit_mm) for one in form)
    verdict, reason = _verdict(deviations, profile, hidden, factor)
    return PieceJudgement(
        verdict, reason, deviations, profile, factor, tuple(readings), tuple(notes)
    )


def _coverage_factor(count: int) -> float:
    alone = 1.0 - (1.0 - FALSE_ALARM) ** (1.0 / max(count, 1))
    return float(-ndtri(0.5 * alone) / COVERAGE_FACTOR)


def _deviation(told: Told, factor: float, limit_mm: float | None) -> PieceDeviation:
    allowed = max(factor * told.u95_mm, limit_mm or 0.0)
    coarsest = COARSEST_U95_MM if limit_mm is None else limit_mm
    if not abs(told.off_mm) <= allowed:
        verdict = PieceVerdict.DRIFTED
    elif told.u95_mm <= coarsest and abs(told.off_mm) <= (limit_mm or allowed):
        verdict = PieceVerdict.TRUE
    else:
        verdict = PieceVerdict.UNKNOWN
    found = told.certified_mm + told.off_mm
    return PieceDeviation(told.name, told.certified_mm, found, told.u95_mm, verdict)


def _part(told: Told, factor: float, limit_mm: float | None) -> PieceDeviation:
    """Judge a part of the profile: it may tell of a drift, but is no evidence that is needed."""
    judged = _deviation(told, factor, limit_mm)
    if judged.verdict is PieceVerdict.UNKNOWN:
        return replace(judged, verdict=PieceVerdict.TRUE)
    return judged


def _verdict(
    deviations: Sequence[PieceDeviation],
    profile: Sequence[PieceDeviation],
    hidden: Sequence[int],
    factor: float,
) -> tuple[PieceVerdict, str]:
    """Return the verdict of all, and the reason: what is worst first."""
    drifted = [one for one in (*deviations, *profile) if one.verdict is PieceVerdict.DRIFTED]
    if drifted:
        worst = max(drifted, key=lambda one: abs(one.off_mm) / one.u95_mm)
        return PieceVerdict.DRIFTED, (
            f"{worst.name} is off by {worst.off_mm:+.4f} mm; {factor * worst.u95_mm:.4f} "
            "is what uncertainty allows"
        )
    if all(one.name in _OF_THE_HOLDER for one in deviations):
        return PieceVerdict.UNKNOWN, (
            "what is seen of the piece tells none of its dimensions: show sides at two levels, or "
            "of two directions"
        )
    if hidden:
        sides = ", ".join(str(index + 1) for index in sorted(hidden))
        return PieceVerdict.UNKNOWN, f"of side {sides} less than half is seen; show the whole piece"
    coarse = [one for one in (*deviations, *profile) if one.verdict is PieceVerdict.UNKNOWN]
    if coarse:
        worst = max(coarse, key=lambda one: one.u95_mm)
        return PieceVerdict.UNKNOWN, (
            f"{worst.name} is known to {worst.u95_mm:.4f} mm only (off by {worst.off_mm:+.4f}); "
            "take more placements, or calibrate better"
        )
    largest = max(deviations, key=lambda one: abs(one.off_mm))
    return PieceVerdict.TRUE, (
        f"{len(deviations)} dimensions, the worst, {largest.name}, off by {largest.off_mm:+.4f} mm"
    )
