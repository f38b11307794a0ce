"""The gauges on MiniProf files, beside what the headers of the files say."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from measure import (
    MeasureError,
    Profile,
    Quantity,
    format_miniprof,
    gauge_profile,
    parse_miniprof,
    reference_profile,
)
from station.errors import InputUnusable
from station.progress import Progress
from station.scenes import WheelTruth
from station.tables import Table, Value

ASKED_MM = 0.05
_OTHER_POINTS_MM = 2.0
"""A header farther off states the figures of another wheel: old files keep a template's."""
_CLAIMED = (
    Quantity.FLANGE_HEIGHT,
    Quantity.FLANGE_THICKNESS_10,
    Quantity.FLANGE_GRADIENT_QR,
)
_SUFFIXES = (".whl", ".mpt", ".txt")
# A MiniProf has a point every 0.3 mm or so, good to some micrometres, on a wheel that is no mirror.
_SPACING_MM, _SCATTER_MM = 0.3, 0.005
_BACK_BELOW_MM, _FIELD_D_MM = -22.0, 128.0


def bench_profiles(progress: Progress, *, folder: Path | None = None, seed: int = 1) -> Table:
    """Gauge profiles in MiniProf text and compare with their headers.

    Parameters
    ----------
    progress
        Told where the bench is.
    folder
        Where MiniProf files of real wheels are (.whl, .mpt, .txt); without it made-up worn wheels
        are gauged, whose headers come from their outlines by the definitions of the gauges.
    seed
        Of the scatter of made-up points.

    Raises
    ------
    InputUnusable
        If the folder holds no such file.
    """
    rows = []
    for name, text in _texts(folder, seed):
        progress(0.0, name)
        rows.append(_row(name, text))
    notes = (
        f"Read less stated by the header, mm; asked: {ASKED_MM:g} at most. A header more than "
        f"{_OTHER_POINTS_MM:g} mm off is not of these points.",
    )
    return Table("MiniProf files", rows, notes)


def _texts(folder: Path | None, seed: int) -> Iterator[tuple[str, str]]:
    if folder is None:
        yield from _made_up(np.random.default_rng(seed))
        return
    files = sorted(p for p in folder.glob("*") if p.suffix.lower() in _SUFFIXES)
    if not files:
        raise InputUnusable(f"{folder} holds no {', '.join(_SUFFIXES)}; give MiniProf files")
    for path in files:
        yield path.name, path.read_text(encoding="latin-1")


def _made_up(rng: np.random.Generator) -> Iterator[tuple[str, str]]:
    for reference in ("S1002", "LMA"):
        for tread_mm, flange_mm in ((0.0, 0.0), (2.0, 1.0), (5.0, 0.5), (8.0, 4.0)):
            wheel = WheelTruth(reference, tread_wear_mm=tread_mm, flange_wear_mm=flange_mm)
            name = f"{reference}, tread worn {tread_mm:g}, flange {flange_mm:g} mm"
            yield name, _miniprof_of(wheel, rng)


def _miniprof_of(wheel: WheelTruth, rng: np.random.Generator) -> str:
    """Return what an instrument would have written of a wheel, its figures the true ones."""
    outline = wheel.profile.points_mm + [70.0, 0.0]
    touched = (outline[:, 1] > _BACK_BELOW_MM) & (outline[:, 0] < _FIELD_D_MM)
    line = outline[touched]
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    along = np.arange(0.0, length[-1], _SPACING_MM)
    d, h = (np.interp(along, length, column) for column in line.T)
    d, h = (values + rng.normal(0.0, _SCATTER_MM, len(along)) for values in (d, h))
    true = wheel.readings
    header = {
        "Sd": f"{true.flange_thickness_10:.4f}",
        "Sh": f"{true.flange_height:.4f}",
        "qR": f"{true.flange_gradient_qr:.4f}",
    }
    return format_miniprof(Profile(d, h, np.zeros(len(d))), header)


def _row(name: str, text: str) -> dict[str, Value]:
    row: dict[str, Value] = {"wheel": name}
    try:
        parsed = parse_miniprof(text)
    except MeasureError as error:
        return row | dict.fromkeys(_CLAIMED, "") | {"points": 0, "holds": f"unreadable: {error}"}
    answer = gauge_profile(parsed.profile, reference_profile("S1002"), levels=parsed.levels)
    claimed, differences = parsed.claimed, []
    for quantity in _CLAIMED:
        value = answer.readings[quantity].value
        if quantity not in claimed:
            row[quantity.value] = "not stated" if value is None else f"{value:.3f}, not stated"
        elif value is None:
            row[quantity.value] = "not read"
            differences.append(float("inf"))
        else:
            differences.append(value - claimed[quantity])
            row[quantity.value] = differences[-1]
    return row | {"points": len(parsed.profile), "holds": _judgement(differences)}


def _judgement(differences_mm: Sequence[float]) -> bool | str:
    if not differences_mm:
        return "nothing stated"
    largest = max(map(abs, differences_mm))
    if _OTHER_POINTS_MM < largest < float("inf"):
        return "states another wheel"
    return largest <= ASKED_MM
