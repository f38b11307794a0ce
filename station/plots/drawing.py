"""One drawing: the wheels of a measurement one below the other, or a file for each.

How many wheels there are is known only when they are measured. A file therefore takes them all,
each at full size, and is there under the name that a script waits for; a folder takes a file a
wheel, as a wheel's own record wants it.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

from measure import ReferenceProfile
from station.documents import ProfileDocument, WheelDocument, write_whole
from station.exports import file_for_each, is_folder
from station.plots.legend import key, readings_table
from station.plots.panel import Panel, text
from station.plots.profile_panel import D_MM, H_MM, profile_marks
from station.plots.shape import Drawn
from station.plots.wear_panel import shared_u95, wear_marks, wear_scale

_SCALE = 6.0  # px a mm
_LEFT_PX, _RIGHT_PX = 46.0, 16.0
_TITLE_PX, _GAP_PX, _FOOT_PX = 52.0, 46.0, 40.0
_WEAR_PX = 150.0
_WIDTH_PX = _LEFT_PX + (D_MM[1] - D_MM[0]) * _SCALE + _RIGHT_PX
_PROFILE_PX = (H_MM[1] - H_MM[0]) * _SCALE
_WHEEL_PX = _TITLE_PX + _PROFILE_PX + _GAP_PX + _WEAR_PX + _FOOT_PX
_STYLE = (
    "text{font:12px sans-serif;fill:#222}text.head-line{font-weight:bold;font-size:14px}"
    "text.tick,text.title,text.mark{font-size:11px;fill:#555}text.figure{fill:#0b4a8f}"
    "text.alarm{fill:#b00020;font-weight:bold}"
    ".grid{stroke:#eee}.frame{fill:none;stroke:#999}.datum{stroke:#777;stroke-dasharray:8 3 2 3}"
    ".level{stroke:#0b4a8f;stroke-width:.6;stroke-dasharray:2 2}.gauge{stroke:#0b4a8f}"
    ".head{fill:#0b4a8f}.touch{fill:#fff;stroke:#0b4a8f;stroke-width:1.5}.tip{fill:#222}"
    ".reference{fill:none;stroke:#666;stroke-dasharray:6 3}"
    ".measured,.wear-line{fill:none;stroke:#b3261e;stroke-width:1.6}"
    ".by-1{stroke:#1f6feb}.by-2{stroke:#1a7f37}.by-3{stroke:#8250df}.by-4{stroke:#bf8700}"
    ".by-several{stroke:#b3261e}"
    ".wear{fill:#f6b26b;fill-opacity:.55}.band{fill:#b3261e;fill-opacity:.18}"
)


def profile_svg(wheels: Sequence[WheelDocument], reference: ReferenceProfile) -> str:
    """Draw measured wheels over the reference they were measured by, one below the other.

    Wheels without a profile are left out; without any there is nothing but their reasons.
    """
    blocks = [list(_block(wheel, reference, place)) for place, wheel in enumerate(wheels)]
    height = _WHEEL_PX * max(1, len(blocks))
    return "\n".join([
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH_PX:.0f} {height:.0f}" '
        f'width="{_WIDTH_PX:.0f}" height="{height:.0f}">',
        f"<style>{_STYLE}</style>",
        '<rect width="100%" height="100%" fill="#fff"/>',
        *(mark for block in blocks for mark in block),
        "</svg>",
        "",
    ])


def write_plots(
    target: Path, wheels: Sequence[WheelDocument], reference: ReferenceProfile
) -> list[Path]:
    """Write drawings and return what was written: one file for all wheels, or a folder of one each.

    Raises
    ------
    InputUnusable
        If a file cannot be written.
    """
    if not is_folder(target):
        write_whole(target, profile_svg(wheels, reference))
        return [target]
    measured = [wheel for wheel in wheels if wheel.profile is not None]
    paths = file_for_each(target, measured, ".svg")
    for path, wheel in zip(paths, measured, strict=True):
        write_whole(path, profile_svg([wheel], reference))
    return paths


def _block(wheel: WheelDocument, reference: ReferenceProfile, place: int) -> Iterator[str]:
    top = place * _WHEEL_PX
    yield text("head-line", (_LEFT_PX, top + 20.0), _title(wheel, reference))
    if wheel.profile is None:
        yield text("row", (_LEFT_PX, top + 40.0), f"not measured: {wheel.reason}")
    else:
        yield from _panels(wheel, wheel.profile, reference, top)


def _panels(
    wheel: WheelDocument, profile: ProfileDocument, reference: ReferenceProfile, top_px: float
) -> Iterator[str]:
    drawn = Drawn.of(wheel, profile, reference, H_MM[0])
    above = Panel(_LEFT_PX, top_px + _TITLE_PX, D_MM, H_MM, _SCALE, _SCALE)
    yield from profile_marks(above, wheel, drawn, reference)
    yield from readings_table(above, wheel)
    yield from key(above, reference.name, profile)
    span, ticks = wear_scale(drawn, shared_u95(wheel))
    below_px = above.top_px + above.height_px + _GAP_PX
    below = Panel(_LEFT_PX, below_px, D_MM, span, _SCALE, _WEAR_PX / (span[1] - span[0]))
    yield from wear_marks(below, wheel, drawn, ticks)
    foot = "distance from the flange back d, mm"
    yield below.text("title", (D_MM[1], span[0]), foot, anchor="end", down_px=31.0)


def _title(wheel: WheelDocument, reference: ReferenceProfile) -> str:
    where = wheel.source if wheel.frame is None else f"{wheel.source} frame {wheel.frame}"
    return f"{where} over {reference.name}"
