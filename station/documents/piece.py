"""The reference piece's certificate (treadline-piece), and what a check came to."""

from dataclasses import asdict
from typing import Literal, Self

from pydantic import AwareDatetime, Field, model_validator

from measure import (
    MeasureError,
    Piece,
    PieceDeviation,
    PieceJudgement,
    PiecePlace,
    PiecePower,
    PieceReading,
    PieceVerdict,
)
from station.documents.base import Document

_Point = tuple[float, float]


class ArcDocument(Document):
    """A round side: from the corner before, through a point, to the next corner; (x, z) in mm."""

    through: _Point
    to: _Point


class PieceDocument(Document):
    """A reference piece as certified at 20 degrees C."""

    format: Literal["treadline-piece"] = "treadline-piece"
    version: Literal[1] = 1
    name: str
    serial: str = ""
    profile: tuple[_Point | ArcDocument, ...]
    """Corners (x, z) in mm, left to right with the metal below; the lit sides only."""
    u95_mm: float = 0.0
    """Of each certified dimension."""
    expansion_per_k: float = 0.0
    """Growth by warmth; without it the piece counts as one that does not grow."""
    squareness_deg: float = 0.5
    """How far the holder may let the piece stand from square to the sheet, or from `length_in_rig`,
    in 95 % of cases."""
    held_u95_mm: float | None = None
    """How well its holder keeps it in place from check to check; null of one put there by hand."""
    length_in_rig: tuple[float, float, float] | None = None
    """Direction of the rig frame along which its holder keeps its length; null: square to the
    sheets, as far as these agree."""

    @model_validator(mode="after")
    def _check_profile(self) -> Self:
        try:
            self.piece()
        except MeasureError as error:
            raise ValueError(str(error)) from error
        return self

    def piece(self) -> Piece:
        """Return the piece itself."""
        corners = [
            [corner.through, corner.to] if isinstance(corner, ArcDocument) else [corner]
            for corner in self.profile
        ]
        return Piece.from_corners(
            self.name,
            self.serial,
            corners,
            u95_mm=self.u95_mm,
            expansion_per_k=self.expansion_per_k,
            squareness_deg=self.squareness_deg,
            held_u95_mm=self.held_u95_mm,
            length_in_rig=self.length_in_rig,
        )


class PieceDeviationDocument(Document):
    """One dimension, or one part of the profile, against the certificate; mm."""

    name: str
    certified: float
    found: float
    off: float
    u95: float
    verdict: PieceVerdict

    @classmethod
    def of(cls, deviation: PieceDeviation) -> Self:
        """Take over what was found."""
        return cls(
            name=deviation.name,
            certified=deviation.certified_mm,
            found=deviation.found_mm,
            off=deviation.off_mm,
            u95=deviation.u95_mm,
            verdict=deviation.verdict,
        )


class PiecePlaceDocument(Document):
    """Where a piece lies on the sheet of one calibration."""

    s_mm: float
    t_mm: float
    turn_rad: float
    u95_mm: float
    turn_u95_rad: float

    @classmethod
    def of(cls, place: PiecePlace) -> Self:
        """Take over a place."""
        return cls(**asdict(place))

    def place(self) -> PiecePlace:
        """Return the place itself."""
        return PiecePlace(**self.model_dump())


class PiecePictureDocument(Document):
    """One picture of the piece: how it was read, or why it was not."""

    name: str
    points: int
    rms_mm: float | None = None
    place: PiecePlaceDocument | None = None
    """Where the middle of the piece lies on the sheet, and how it is turned."""
    reason: str | None = None
    sensor: str | None = None
    """Which of a rig's sensors took it; null of one alone."""

    @classmethod
    def of(cls, reading: PieceReading) -> Self:
        """Take over a reading."""
        sensor = reading.sensor or None
        if reading.reason:
            return cls(
                name=reading.name, points=reading.points, reason=reading.reason, sensor=sensor
            )
        return cls(
            name=reading.name,
            sensor=sensor,
            points=reading.points,
            rms_mm=reading.rms_mm,
            place=None if reading.place is None else PiecePlaceDocument.of(reading.place),
        )


class PiecePowerDocument(Document):
    """The least drift of one kind that would be found in 95 % of such checks."""

    name: str
    found_from: float
    unit: Literal["mm", "rad"]

    @classmethod
    def of(cls, power: PiecePower) -> Self:
        """Take over a power."""
        return cls(**asdict(power))


class PieceCheck(Document):
    """What a sensor, or the sensors of a rig together, said of a reference piece, to be kept."""

    format: Literal["treadline-piece-check"] = "treadline-piece-check"
    version: Literal[1] = 1
    created: AwareDatetime
    software: str
    sensor: str
    """The sensor under test, or the rig."""
    calibration: str
    """Fingerprint of the calibration under test, or of the rig's."""
    piece: str
    serial: str
    verdict: PieceVerdict
    reason: str
    limit_mm: float | None = None
    temperature_c: float | None = None
    coverage_factor: float
    """What u95 is multiplied by, as the largest of all deviations is judged."""
    deviations: tuple[PieceDeviationDocument, ...]
    profile: tuple[PieceDeviationDocument, ...]
    """Mean distance from the certified profile, part by part; `certified` is the place along it."""
    pictures: tuple[PiecePictureDocument, ...]
    notes: tuple[str, ...] = Field(default=())
    powers: tuple[PiecePowerDocument, ...] = Field(default=())
    """Of a rig: which drifts of its sensors against each other would have been found."""

    @property
    def passed(self) -> bool:
        """Whether the sensor tells the truth; not where it could not be said."""
        return self.verdict is PieceVerdict.TRUE

    @property
    def place(self) -> PiecePlace | None:
        """Where the piece was seen; None if nowhere, or if it was moved between the pictures."""
        places = [one.place.place() for one in self.pictures if one.place is not None]
        return PiecePlace.mean(places) if places else None


def piece_check(
    judged: PieceJudgement,
    piece: Piece,
    *,
    created: AwareDatetime,
    software: str,
    sensor: str,
    calibration: str,
    limit_mm: float | None,
    temperature_c: float | None,
) -> PieceCheck:
    """Return the document of a judgement."""
    return PieceCheck(
        created=created,
        software=software,
        sensor=sensor,
        calibration=calibration,
        piece=piece.name,
        serial=piece.serial,
        verdict=judged.verdict,
        reason=judged.reason,
        limit_mm=limit_mm,
        temperature_c=temperature_c,
        coverage_factor=judged.coverage_factor,
        deviations=tuple(map(PieceDeviationDocument.of, judged.deviations)),
        profile=tuple(map(PieceDeviationDocument.of, judged.profile)),
        pictures=tuple(map(PiecePictureDocument.of, judged.readings)),
        notes=judged.notes,
        powers=tuple(map(PiecePowerDocument.of, judged.powers)),
    )
