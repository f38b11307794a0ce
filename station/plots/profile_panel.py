"""The profile over its reference, to one scale, with the gauges laid on."""

from collections.abc import Iterator

import numpy as np

from calib import FloatArray
from measure import ReferenceProfile
from station.documents import WheelDocument
from station.plots.gauges import gauges_of
from station.plots.legend import line_of
from station.plots.panel import Panel
from station.plots.shape import Drawn

BACK_TO_TAPE_MM = 70.0
D_MM = (-10.0, 145.0)
H_MM = (-28.0, 34.0)
H_TICKS = tuple(range(-20, 31, 10))
_STEP_MM = 0.25
_BACK_FACE_MM = 20.0


def profile_marks(
    panel: Panel, wheel: WheelDocument, drawn: Drawn, reference: ReferenceProfile
) -> Iterator[str]:
    """Draw grid, wear, reference, profile with its band, and the gauges."""
    yield from panel.axes(10.0, H_TICKS, "height, mm (one scale both ways)")
    for run in drawn.runs():
        lost = drawn.lost(run)
        if lost is not None:
            yield panel.polygon("wear", lost)
    yield panel.polyline("reference", outline_mm(reference))
    for run in drawn.runs():
        yield panel.polygon("band", drawn.band(run))
        for bits, strand in drawn.strands(run):
            yield panel.polyline(line_of(bits), drawn.points_mm[strand])
    yield from _datums(panel, drawn)
    yield from _dimensions(panel, wheel, drawn)


def outline_mm(reference: ReferenceProfile) -> FloatArray:
    """Return the reference with a piece of its back face as points (d, h), shape (N, 2)."""
    outline = reference.points(_STEP_MM, back_face_mm=_BACK_FACE_MM)
    from_back: FloatArray = outline + np.array([BACK_TO_TAPE_MM, 0.0])
    return from_back


def _datums(panel: Panel, drawn: Drawn) -> Iterator[str]:
    low, high = H_MM
    tape = drawn.levels.tape_d_mm
    yield panel.line("datum", (0.0, low), (0.0, high))
    yield panel.text("mark", (0.0, low + 1.0), "flange back", anchor="start", down_px=-2.0)
    yield panel.line("datum", (tape, low), (tape, high))
    yield panel.text("mark", (tape, low + 1.0), f" tape circle, {tape:g}", down_px=-2.0)
    yield panel.dot("tip", drawn.tip_mm)
    yield panel.text("mark", drawn.tip_mm, "tip", anchor="middle", down_px=-7.0)


def _dimensions(panel: Panel, wheel: WheelDocument, drawn: Drawn) -> Iterator[str]:
    """Draw flange height, thicknesses and gradient where they were read."""
    for gauge in gauges_of(wheel, drawn):
        for ends in gauge.levels:
            yield panel.line("level", *ends)
        for place in gauge.touches:
            yield panel.dot("touch", place)
        yield panel.arrow("gauge", *gauge.ends)
        yield panel.text(
            "figure", gauge.words_at, gauge.words, anchor=gauge.anchor, down_px=gauge.down_px
        )
