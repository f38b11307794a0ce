"""A measured profile over its reference, as SVG."""

from collections.abc import Iterable
from xml.sax.saxutils import escape

import numpy as np

from measure import Quantity, ReferenceProfile
from station.documents import ReadingDocument, WheelDocument

_SCALE = 6.0  # px a mm
_LEFT_MM, _RIGHT_MM, _TOP_MM, _BOTTOM_MM = -8.0, 140.0, 36.0, -24.0
_BACK_TO_TAPE_MM = 70.0
_STYLE = (
    "text{font:12px sans-serif;fill:#222}.reference{fill:none;stroke:#888;stroke-dasharray:5 3}"
    ".measured{fill:none;stroke:#c22;stroke-width:1.5}.gauge{stroke:#27c;stroke-width:1}"
)
_LISTED = (
    (Quantity.FLANGE_HEIGHT, "Sh"),
    (Quantity.FLANGE_THICKNESS_10, "Sd"),
    (Quantity.FLANGE_GRADIENT_QR, "qR"),
    (Quantity.TREAD_WEAR, "tread wear"),
)


def profile_svg(wheel: WheelDocument, reference: ReferenceProfile) -> str:
    """Draw the profile of a measured wheel over the reference, with the gauge lines."""
    width, height = _place(_RIGHT_MM, _BOTTOM_MM)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}">',
        f"<style>{_STYLE}</style>",
        '<rect width="100%" height="100%" fill="#fff"/>',
        *_gauge_lines(wheel),
        _polyline("reference", reference.points(0.25) + [_BACK_TO_TAPE_MM, 0.0]),
    ]
    if wheel.profile is not None:
        points = np.column_stack([wheel.profile.d_mm, wheel.profile.h_mm])
        parts.append(_polyline("measured", points))
    parts += _legend(wheel, reference.name)
    return "\n".join([*parts, "</svg>", ""])


def _place(d_mm: float, h_mm: float) -> tuple[float, float]:
    return (d_mm - _LEFT_MM) * _SCALE, (_TOP_MM - h_mm) * _SCALE


def _polyline(name: str, points_mm: np.ndarray) -> str:
    places = " ".join("{:.1f},{:.1f}".format(*_place(d, h)) for d, h in points_mm)
    return f'<polyline class="{name}" points="{places}"/>'


def _gauge_lines(wheel: WheelDocument) -> Iterable[str]:
    """Draw the tape circle, and flange thickness where it is read."""
    yield _line((_BACK_TO_TAPE_MM, _BOTTOM_MM + 4.0), (_BACK_TO_TAPE_MM, _TOP_MM - 4.0))
    thickness = wheel.flange_thickness_10.value
    if thickness is None or wheel.profile is None:
        return
    d_mm, h_mm = np.array(wheel.profile.d_mm), np.array(wheel.profile.h_mm)
    order = np.argsort(d_mm)
    level_mm = float(np.interp(_BACK_TO_TAPE_MM, d_mm[order], h_mm[order])) + 10.0
    yield _line((0.0, level_mm), (thickness, level_mm))


def _line(start_mm: tuple[float, float], end_mm: tuple[float, float]) -> str:
    (x1, y1), (x2, y2) = _place(*start_mm), _place(*end_mm)
    return f'<line class="gauge" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"/>'


def _legend(wheel: WheelDocument, reference: str) -> Iterable[str]:
    readings = wheel.readings
    texts = [f"{wheel.source} frame {wheel.frame}", f"dashed: {reference}"]
    texts += [f"{short} {_shown(readings[quantity])}" for quantity, short in _LISTED]
    for row, text in enumerate(texts):
        yield f'<text x="{_place(85.0, 0.0)[0]:.0f}" y="{20 + 16 * row}">{escape(text)}</text>'


def _shown(reading: ReadingDocument) -> str:
    if reading.value is None:
        return "missing"
    return f"{reading.value:.2f} ± {reading.u95:.2f} mm"
