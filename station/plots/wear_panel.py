"""How the wear is spread over the tread, with its 95 % band."""

from collections.abc import Iterator

import numpy as np

from calib import FloatArray
from station.documents import WheelDocument
from station.plots.panel import Panel, Place
from station.plots.shape import Drawn

# Ahead of it the flange's face is so steep that a difference of heights says little.
_FROM_D_MM = 45.0
# Beyond it wheels of one tread are chamfered as they please: it must not set the scale.
_SCALED_TO_D_MM = 118.0
_STEPS_MM = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
_MOST_TICKS = 6
_LEAST_MM = 0.1
_HEADROOM = 1.2


def tread_wear(drawn: Drawn) -> tuple[FloatArray, FloatArray]:
    """Return (d, wear) of the tread, shape (N, 2), and half the band of each point's scatter."""
    d = drawn.points_mm[:, 0]
    shown = np.isfinite(drawn.wear_mm) & (d >= _FROM_D_MM)
    return np.column_stack([d[shown], drawn.wear_mm[shown]]), drawn.half_band_mm[shown]


def wear_scale(drawn: Drawn, u95_mm: float) -> tuple[Place, tuple[float, ...]]:
    """Return the range of wear to show and the ticks in it."""
    d, wear = tread_wear(drawn)[0].T
    wear = wear[d <= _SCALED_TO_D_MM]
    low = min(0.0, float(wear.min(initial=0.0)) - u95_mm)
    high = max(_LEAST_MM, (float(wear.max(initial=0.0)) + u95_mm) * _HEADROOM)
    step = next(s for s in _STEPS_MM if (high - low) / s <= _MOST_TICKS or s == _STEPS_MM[-1])
    first, last = int(np.floor(low / step)), int(np.ceil(high / step))
    ticks = tuple(round(count * step, 6) for count in range(first, last + 1))
    return (ticks[0], ticks[-1]), ticks


def wear_marks(
    panel: Panel, wheel: WheelDocument, drawn: Drawn, ticks: tuple[float, ...]
) -> Iterator[str]:
    """Draw the wear, its band, the tape circle, and where it is greatest."""
    yield from panel.axes(10.0, ticks, "wear of the tread, mm (reference minus height)")
    low, high = panel.v_mm
    tape = drawn.levels.tape_d_mm
    yield panel.line("datum", (tape, low), (tape, high))
    yield panel.line("reference", (panel.d_mm[0], 0.0), (panel.d_mm[1], 0.0))
    points, half = tread_wear(drawn)
    # The points' own scatter, and what all share: datum, calibration, survey.
    band = np.hypot(half, shared_u95(wheel))
    inside = (points[:, 1] + band <= high) & (points[:, 1] - band >= low)
    points, band = points[inside], band[inside]
    if len(points) >= 2:
        upper, lower = points + [[0.0, 1.0]] * band[:, None], points - [[0.0, 1.0]] * band[:, None]
        yield panel.polygon("band", np.concatenate([upper, lower[::-1]]))
        yield panel.polyline("wear-line", points)
    most, at_d = wheel.tread_wear_max.value, wheel.quality.get("wear_max_at_d_mm")
    if most is not None and at_d is not None:
        yield panel.dot("touch", (at_d, most))
        yield panel.text("figure", (at_d, most), f" most: {most:.2f} at d = {at_d:.0f}", down_px=-6)


def shared_u95(wheel: WheelDocument) -> float:
    """Return the 95 % uncertainty that the whole wear profile shares."""
    return wheel.tread_wear_at_70.u95 or 0.0
