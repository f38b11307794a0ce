"""Where the gauges lie on a measured wheel: the places and words of all drawings of it."""

from collections.abc import Iterator
from dataclasses import dataclass

from measure import Quantity
from station.documents import WheelDocument
from station.plots.panel import Place
from station.plots.shape import Drawn

_SH_AT_D_MM = 60.0
_QR_BELOW_FACE_MM = 5.0


@dataclass(frozen=True, slots=True)
class Gauge:
    """One reading, laid on the profile as a dimension; all places (d, h), mm.

    Attributes
    ----------
    quantity
        What is read.
    ends
        Of the dimension's line.
    words, words_at, anchor, down_px
        What is written, where, from which end, and how far below.
    levels
        Thin lines that lead to it.
    touches
        Where it touches the wheel.
    """

    quantity: Quantity
    ends: tuple[Place, Place]
    words: str
    words_at: Place
    anchor: str = "start"
    down_px: float = 0.0
    levels: tuple[tuple[Place, Place], ...] = ()
    touches: tuple[Place, ...] = ()


def gauges_of(wheel: WheelDocument, drawn: Drawn) -> Iterator[Gauge]:
    """Yield flange height, thicknesses and gradient where they were read."""
    height = wheel.flange_height.value
    if height is None:
        return
    tread = drawn.tip_mm[1] - height
    yield _height(drawn, tread, height)
    for quantity, above_mm, down_px in (
        (Quantity.FLANGE_THICKNESS_12, 12.0, -4.0),
        (Quantity.FLANGE_THICKNESS_10, drawn.levels.face_mm, 12.0),
    ):
        value = wheel.readings[quantity].value
        if value is not None:
            words = f"at +{above_mm:g}: {value:.2f}"
            if quantity is Quantity.FLANGE_THICKNESS_10:
                words = f"Sd {words}"
            level = tread + above_mm
            ends = ((0.0, level), (value, level))
            yield Gauge(quantity, ends, words, (2.0, level), down_px=down_px)
    yield from _gradient(wheel, drawn, tread)


def _height(drawn: Drawn, tread_mm: float, height_mm: float) -> Gauge:
    tip_d, tip_h = drawn.tip_mm
    return Gauge(
        Quantity.FLANGE_HEIGHT,
        ((_SH_AT_D_MM, tread_mm), (_SH_AT_D_MM, tip_h)),
        f"Sh {height_mm:.2f}",
        (_SH_AT_D_MM + 1.0, tread_mm + height_mm / 2.0),
        levels=(
            ((0.0, tread_mm), (drawn.levels.tape_d_mm, tread_mm)),
            ((tip_d, tip_h), (_SH_AT_D_MM + 2.0, tip_h)),
        ),
    )


def _gradient(wheel: WheelDocument, drawn: Drawn, tread_mm: float) -> Iterator[Gauge]:
    face = wheel.flange_thickness_10.value
    gradient = wheel.flange_gradient_qr.value
    if face is None or gradient is None:
        return
    lower = (face, tread_mm + drawn.levels.face_mm)
    upper = (face - gradient, drawn.tip_mm[1] - drawn.levels.below_tip_mm)
    level = lower[1] - _QR_BELOW_FACE_MM
    yield Gauge(
        Quantity.FLANGE_GRADIENT_QR,
        ((upper[0], level), (lower[0], level)),
        f"qR {gradient:.2f} ",
        (upper[0], level),
        anchor="end",
        down_px=4.0,
        levels=tuple((place, (place[0], level - 1.0)) for place in (lower, upper)),
        touches=(lower, upper),
    )
