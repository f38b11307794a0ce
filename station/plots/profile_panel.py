"""The profile over its reference, to one scale, with the gauges laid on."""

from collections.abc import Iterator

import numpy as np

from measure import Quantity, ReferenceProfile
from station.documents import WheelDocument
from station.plots.legend import line_of
from station.plots.panel import Panel
from station.plots.shape import Drawn

BACK_TO_TAPE_MM = 70.0
D_MM = (-10.0, 145.0)
H_MM = (-28.0, 34.0)
H_TICKS = tuple(range(-20, 31, 10))
_SH_AT_D_MM = 60.0
_QR_BELOW_FACE_MM = 5.0
_STEP_MM = 0.25
_BACK_FACE_MM = 20.0


def profile_marks(
    panel: Panel, wheel: WheelDocument, drawn: Drawn, reference: ReferenceProfile
) -> Iterator[str]:
    """Draw grid, wear, reference, profile with its band, and the gauges."""
    yield from panel.axes(10.0, H_TICKS, "height, mm (one scale both ways)")
    lost = np.isfinite(drawn.wear_mm)
    for run in drawn.runs():
        points, wear = drawn.points_mm[run][lost[run]], drawn.wear_mm[run][lost[run]]
        if len(points) >= 2:
            # Where metal stands above the reference nothing is worn off.
            above = points + np.column_stack([np.zeros(len(wear)), np.maximum(wear, 0.0)])
            yield panel.polygon("wear", np.concatenate([points, above[::-1]]))
    outline = reference.points(_STEP_MM, back_face_mm=_BACK_FACE_MM)
    yield panel.polyline("reference", outline + [BACK_TO_TAPE_MM, 0.0])
    for run in drawn.runs():
        yield panel.polygon("band", drawn.band(run))
        for bits, strand in drawn.strands(run):
            yield panel.polyline(line_of(bits), drawn.points_mm[strand])
    yield from _datums(panel, drawn)
    yield from _dimensions(panel, wheel, drawn)


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
    height = wheel.flange_height.value
    if height is None:
        return
    tip_d, tip_h = drawn.tip_mm
    tread = tip_h - height
    tape = drawn.levels.tape_d_mm
    yield panel.line("level", (0.0, tread), (tape, tread))
    yield panel.line("level", (tip_d, tip_h), (_SH_AT_D_MM + 2.0, tip_h))
    yield panel.arrow("gauge", (_SH_AT_D_MM, tread), (_SH_AT_D_MM, tip_h))
    middle = (_SH_AT_D_MM + 1.0, tread + height / 2.0)
    yield panel.text("figure", middle, f"Sh {height:.2f}")
    levels = drawn.levels
    for quantity, above_mm, down_px in (
        (Quantity.FLANGE_THICKNESS_12, 12.0, -4.0),
        (Quantity.FLANGE_THICKNESS_10, levels.face_mm, 12.0),
    ):
        value = wheel.readings[quantity].value
        if value is not None:
            level = tread + above_mm
            yield panel.arrow("gauge", (0.0, level), (value, level))
            words = f"at +{above_mm:g}: {value:.2f}"
            if quantity is Quantity.FLANGE_THICKNESS_10:
                words = f"Sd {words}"
            yield panel.text("figure", (2.0, level), words, down_px=down_px)
    yield from _gradient(panel, wheel, drawn, tread)


def _gradient(panel: Panel, wheel: WheelDocument, drawn: Drawn, tread_mm: float) -> Iterator[str]:
    face = wheel.flange_thickness_10.value
    gradient = wheel.flange_gradient_qr.value
    if face is None or gradient is None:
        return
    lower = (face, tread_mm + drawn.levels.face_mm)
    upper = (face - gradient, drawn.tip_mm[1] - drawn.levels.below_tip_mm)
    level = lower[1] - _QR_BELOW_FACE_MM
    for place in (lower, upper):
        yield panel.line("level", place, (place[0], level - 1.0))
        yield panel.dot("touch", place)
    yield panel.arrow("gauge", (upper[0], level), (lower[0], level))
    yield panel.text("figure", (upper[0], level), f"qR {gradient:.2f} ", anchor="end", down_px=4.0)
