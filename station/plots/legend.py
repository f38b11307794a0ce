"""What the lines of a drawing mean, and the readings in figures."""

from collections.abc import Iterator

from measure import Alarm, Quantity, Status
from station.documents import ProfileDocument, ReadingDocument, WheelDocument
from station.plots.panel import Panel, Place, text

_ROW_PX = 15.0
_LISTED = (
    (Quantity.FLANGE_HEIGHT, "flange height Sh"),
    (Quantity.FLANGE_THICKNESS_10, "flange thickness Sd"),
    (Quantity.FLANGE_THICKNESS_12, "flange thickness, 12 mm"),
    (Quantity.FLANGE_GRADIENT_QR, "flange gradient qR"),
    (Quantity.TREAD_WEAR, "tread wear"),
    (Quantity.TREAD_WEAR_MAX, "greatest tread wear"),
    (Quantity.HOLLOW_DEPTH, "hollow"),
)
_KEY = (("measured", "measured"), ("reference", ""), ("wear", "wear"), ("band", "95 %"))
_FILLED = ("wear", "band")
_COLUMN_PX = 95.0
_AT_D_MM = 77.0
_FIGURES_PX = 145.0
_SAID_PX = 400.0


def readings_table(panel: Panel, wheel: WheelDocument) -> Iterator[str]:
    """Write the readings in the empty field above the tread."""
    x, y = panel.place(_AT_D_MM, panel.v_mm[1] - 3.0)
    claimed = wheel.header.claimed if wheel.header is not None else {}
    if claimed:
        yield text("tick", (x + _SAID_PX, y - 2.0), "header says", anchor="end")
    for row, (quantity, name) in enumerate(_LISTED, start=1):
        reading, at = wheel.readings[quantity], y + row * _ROW_PX
        yield text("row", (x, at), name)
        kind = "alarm" if reading.alarm in {Alarm.ALARM, Alarm.WARNING} else "row"
        yield text(kind, (x + _FIGURES_PX, at), _shown(reading))
        if quantity in claimed:
            yield text("row", (x + _SAID_PX, at), f"{claimed[quantity]:.2f}", anchor="end")


def line_of(bits: int) -> str:
    """Return which line a part of the profile is, by the sensors of a rig that saw it.

    >>> line_of(0), line_of(0b1), line_of(0b100), line_of(0b101)
    ('measured', 'measured by-1', 'measured by-3', 'measured by-several')
    """
    if bits == 0:
        return "measured"
    return f"measured by-{bits.bit_length() if bits.bit_count() == 1 else 'several'}"


def key(panel: Panel, reference: str, profile: ProfileDocument) -> Iterator[str]:
    """Say what each line and each filling is, and which sensor saw what, below the tread."""
    x, y = panel.place(_AT_D_MM, panel.v_mm[0] + 4.0)
    for column, (name, words) in enumerate(_KEY):
        left = x + _COLUMN_PX * column
        if name in _FILLED:
            yield f'<rect class="{name}" x="{left:.1f}" y="{y - 9.0:.1f}" width="22" height="10"/>'
            yield text("tick", (left + 27.0, y), words)
        else:
            yield from _line(name, words or reference, (left, y))
    if profile.seen_by is None:
        return
    seen = [(line_of(1 << place), name) for place, name in enumerate(profile.sensors)]
    for column, (name, words) in enumerate([*seen, (line_of(0b11), "several")]):
        yield from _line(name, words, (x + _COLUMN_PX * column, y - _ROW_PX - 3.0))


def _line(name: str, words: str, place_px: Place) -> Iterator[str]:
    left, y = place_px
    ends = f'x1="{left:.1f}" y1="{y - 4.0:.1f}" x2="{left + 22.0:.1f}" y2="{y - 4.0:.1f}"'
    yield f'<line class="{name}" {ends}/>'
    yield text("tick", (left + 27.0, y), words)


def _shown(reading: ReadingDocument) -> str:
    if reading.value is None or reading.u95 is None:
        return "missing"
    words = f"{reading.value:.2f} \u00b1 {reading.u95:.2f} mm"
    if reading.alarm in {Alarm.ALARM, Alarm.WARNING}:
        words += f" {reading.alarm.value}"
    return words if reading.status is Status.OK else f"{words} ({reading.status.value})"
