"""Measured wheels as MiniProf files, for the programs that depots have."""

from collections.abc import Iterator
from pathlib import Path
from typing import Literal

from measure import EN_15313, Quantity, ascii_fields, format_miniprof
from station.documents import (
    MeasurementDocument,
    ProfileDocument,
    WheelDocument,
    write_whole,
)
from station.exports.targets import file_for_each

SUFFIX = ".whl"
_FIGURES = (
    ("Sd", Quantity.FLANGE_THICKNESS_10),
    ("Sh", Quantity.FLANGE_HEIGHT),
    ("qR", Quantity.FLANGE_GRADIENT_QR),
)
# What a file said of its wheel it says again; its own figures and columns are not ours.
_KEPT = ("Stock", "CarNo", "Bogie", "AxleNo", "Side", "WheelID", "Date", "Time")
_SIDES = {"left": "L", "right": "R"}
_USUAL_MM: tuple[tuple[Literal["L1", "L2", "L3"], float], ...] = (
    ("L1", EN_15313.below_tip_mm),
    ("L2", EN_15313.tape_d_mm),
    ("L3", EN_15313.face_mm),
)


def write_miniprof(target: Path, document: MeasurementDocument) -> list[Path]:
    """Write a MiniProf file for each measured wheel and return what was written.

    Parameters
    ----------
    target
        A file, or a folder: several wheels want one, or are numbered.
    document
        The results.

    Raises
    ------
    InputUnusable
        If a file cannot be written.
    """
    measured = [(wheel, wheel.profile) for wheel in document.wheels if wheel.profile is not None]
    paths = file_for_each(target, [wheel for wheel, _ in measured], SUFFIX)
    for path, (wheel, profile) in zip(paths, measured, strict=True):
        write_whole(path, miniprof_of(wheel, profile, document))
    return paths


def miniprof_of(
    wheel: WheelDocument, profile: ProfileDocument, document: MeasurementDocument
) -> str:
    """Return the text of a wheel's MiniProf file, `document` being the results it is of."""
    return format_miniprof(profile.profile(), ascii_fields(_fields(wheel, document)))


def _fields(wheel: WheelDocument, document: MeasurementDocument) -> Iterator[tuple[str, str]]:
    said = wheel.header.fields if wheel.header is not None else {}
    yield "ProgramName", document.software
    yield "ReferenceProfile", document.reference
    for key in _KEPT:
        if said.get(key):
            yield key, said[key]
    yield from _known(wheel)
    yield "Comment", wheel.source if wheel.frame is None else f"{wheel.source} frame {wheel.frame}"
    levels = wheel.header.levels_mm if wheel.header is not None else {}
    for key, usual_mm in _USUAL_MM:
        yield key, f"{levels.get(key, usual_mm):g}"
    for key, quantity in _FIGURES:
        value = wheel.readings[quantity].value
        if value is not None:
            yield key, f"{value:.4f}"


def _known(wheel: WheelDocument) -> Iterator[tuple[str, str]]:
    if wheel.time is not None:
        yield "Date", wheel.time.strftime("%d/%m/%Y")
        yield "Time", wheel.time.strftime("%H:%M:%S")
    if wheel.side is not None:
        yield "Side", _SIDES[wheel.side]
    if wheel.axle is not None:
        yield "AxleNo", str(wheel.axle)
    if wheel.wheelset is not None:
        yield "WheelID", wheel.wheelset
