"""A field of a drawing: millimetres of a wheel to pixels, and the marks drawn in it."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape, quoteattr

from calib import FloatArray

Place = tuple[float, float]
_TICK_PX = 5.0
_ARROW_PX = 5.0


@dataclass(frozen=True, slots=True)
class Panel:
    """A rectangle that shows a range of d (across) and of heights (up), mm.

    Attributes
    ----------
    left_px, top_px
        Its upper left corner in the drawing.
    d_mm, v_mm
        Ranges shown, least first.
    d_scale, v_scale
        Pixels a millimetre.
    """

    left_px: float
    top_px: float
    d_mm: Place
    v_mm: Place
    d_scale: float
    v_scale: float

    @property
    def width_px(self) -> float:
        """Its width."""
        return (self.d_mm[1] - self.d_mm[0]) * self.d_scale

    @property
    def height_px(self) -> float:
        """Its height."""
        return (self.v_mm[1] - self.v_mm[0]) * self.v_scale

    def place(self, d_mm: float, v_mm: float) -> Place:
        """Return the pixel of a place."""
        x = self.left_px + (d_mm - self.d_mm[0]) * self.d_scale
        return x, self.top_px + (self.v_mm[1] - v_mm) * self.v_scale

    def line(self, name: str, start_mm: Place, end_mm: Place) -> str:
        """Draw a straight line."""
        (x1, y1), (x2, y2) = self.place(*start_mm), self.place(*end_mm)
        return f'<line class="{name}" x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"/>'

    def polyline(self, name: str, points_mm: FloatArray) -> str:
        """Draw points joined by lines, shape (N, 2)."""
        return f'<polyline class="{name}" points="{self._points(points_mm)}"/>'

    def polygon(self, name: str, points_mm: FloatArray) -> str:
        """Fill what points enclose, shape (N, 2)."""
        return f'<polygon class="{name}" points="{self._points(points_mm)}"/>'

    def dot(self, name: str, place_mm: Place) -> str:
        """Draw a small circle."""
        x, y = self.place(*place_mm)
        return f'<circle class="{name}" cx="{x:.1f}" cy="{y:.1f}" r="3"/>'

    def text(
        self, name: str, place_mm: Place, words: str, *, anchor: str = "start", down_px: float = 0.0
    ) -> str:
        """Write words at a place."""
        x, y = self.place(*place_mm)
        return text(name, (x, y + down_px), words, anchor=anchor)

    def arrow(self, name: str, start_mm: Place, end_mm: Place) -> str:
        """Draw a dimension: a line, level or upright, with a head at either end."""
        (x1, y1), (x2, y2) = self.place(*start_mm), self.place(*end_mm)
        a = _ARROW_PX
        if abs(x2 - x1) > abs(y2 - y1):
            left, right = sorted((x1, x2))
            heads = ((left, y1, a, a / 2), (right, y1, -a, a / 2))
            ends = [(x, y, x + dx, y + dy, x + dx, y - dy) for x, y, dx, dy in heads]
        else:
            top, low = sorted((y1, y2))
            heads = ((x1, top, a / 2, a), (x1, low, a / 2, -a))
            ends = [(x, y, x + dx, y + dy, x - dx, y + dy) for x, y, dx, dy in heads]
        drawn = "".join(
            f'<polygon class="head" points="{p[0]:.1f},{p[1]:.1f} {p[2]:.1f},{p[3]:.1f} '
            f'{p[4]:.1f},{p[5]:.1f}"/>'
            for p in ends
        )
        return self.line(name, start_mm, end_mm) + drawn

    def axes(self, d_step: float, v_ticks: Sequence[float], v_title: str) -> Iterator[str]:
        """Draw a grid, its figures in mm, and what they count."""
        low, high = self.v_mm
        first = int(-(-self.d_mm[0] // d_step))
        for count in range(first, int(self.d_mm[1] // d_step) + 1):
            d = count * d_step
            yield self.line("grid", (d, low), (d, high))
            yield self.text("tick", (d, low), f"{d:g}", anchor="middle", down_px=15.0)
        for v in v_ticks:
            yield self.line("grid", (self.d_mm[0], v), (self.d_mm[1], v))
            x, y = self.place(self.d_mm[0], v)
            yield text("tick", (x - _TICK_PX, y + 4.0), f"{v:g}", anchor="end")
        yield self.text("title", (self.d_mm[0], high), v_title, down_px=-6.0)
        yield (
            f'<rect class="frame" x="{self.left_px:.1f}" y="{self.top_px:.1f}" '
            f'width="{self.width_px:.1f}" height="{self.height_px:.1f}"/>'
        )

    def _points(self, points_mm: Iterable[Sequence[float]]) -> str:
        return " ".join("{:.1f},{:.1f}".format(*self.place(d, v)) for d, v in points_mm)


def text(name: str, place_px: Place, words: str, *, anchor: str = "start") -> str:
    """Write words at a pixel."""
    x, y = place_px
    return (
        f'<text class={quoteattr(name)} x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">'
        f"{escape(words)}</text>"
    )
