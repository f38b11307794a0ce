"""Drawings as SVG: axes with ticks, marks and needles; colours come from the page's style."""

from dataclasses import dataclass

import numpy as np

from calib import BoolArray, FloatArray
from station.report.markup import Child, Markup, element
from station.report.wording import minus

_LEFT, _RIGHT, _TOP, _BOTTOM = 60.0, 12.0, 10.0, 40.0
_TICKS = 6
_LARGEST_ENLARGEMENT = 1.2
"""Limited, so that text is of one size in all drawings."""


@dataclass(frozen=True, slots=True)
class Axes:
    """A rectangle of a drawing that stands for a range of two quantities.

    `x` and `y` are (low, high); `width` and `height` are the rectangle's, in units of the drawing;
    with `down` y grows down, as pictures have it.
    """

    x: tuple[float, float]
    y: tuple[float, float]
    width: float
    height: float
    down: bool = False

    @classmethod
    def same_scale(
        cls, x: tuple[float, float], y: tuple[float, float], width: float, *, down: bool
    ) -> "Axes":
        """Make axes on which a length is as long along x as along y."""
        return cls(x, y, width, width * (y[1] - y[0]) / (x[1] - x[0]), down)

    @property
    def scale(self) -> float:
        """Units of the drawing a unit of x."""
        return self.width / (self.x[1] - self.x[0])

    def at(self, points: FloatArray) -> FloatArray:
        """Return where points, shape (N, 2), are in the drawing."""
        low, high = np.array([self.x[0], self.y[0]]), np.array([self.x[1], self.y[1]])
        part = (np.asarray(points, dtype=np.float64).reshape(-1, 2) - low) / (high - low)
        if not self.down:
            part[:, 1] = 1.0 - part[:, 1]
        return np.asarray([_LEFT, _TOP] + part * [self.width, self.height])

    def holds(self, points: FloatArray) -> BoolArray:
        """Tell which points, shape (N, 2), lie within the axes."""
        low, high = np.array([self.x[0], self.y[0]]), np.array([self.x[1], self.y[1]])
        return np.asarray(((points >= low) & (points <= high)).all(axis=1))

    def drawing(self, name: str, x_label: str, y_label: str, *marks: Child) -> Markup:
        """Return the drawing: the axes with their ticks, and the marks upon them."""
        width = _LEFT + self.width + _RIGHT
        height = _TOP + self.height + _BOTTOM
        # An inner svg cuts off what reaches over the axes.
        inner = element(
            "svg", marks, x=_LEFT, y=_TOP, width=self.width, height=self.height,
            viewBox=f"{_LEFT:g} {_TOP:g} {self.width:.6g} {self.height:.6g}",
        )  # fmt: skip
        return element(
            "svg",
            self._ticks_of_x(x_label),
            self._ticks_of_y(y_label),
            inner,
            element("path", d=self._outline(), class_="axes"),
            viewBox=f"0 0 {width:.6g} {height:.6g}",
            style=f"max-width:{_LARGEST_ENLARGEMENT * width:.0f}px",
            role="img",
            aria_label=name,
        )

    def _outline(self) -> str:
        return f"M{_LEFT} {_TOP}h{self.width:.1f}v{self.height:.1f}h{-self.width:.1f}z"

    def _ticks_of_x(self, label: str) -> Markup:
        bottom = _TOP + self.height
        values = ticks(*self.x)
        places = self.at(np.column_stack([values, np.full(len(values), self.y[0])]))[:, 0]
        lines = "".join(f"M{place:.1f} {_TOP}V{bottom:.1f}" for place in places)
        texts = [
            element("text", _tick(value), x=place, y=bottom + 15.0, text_anchor="middle")
            for value, place in zip(values, places, strict=True)
        ]
        middle = _LEFT + self.width / 2.0
        name = element(
            "text", label, x=middle, y=bottom + 33.0, text_anchor="middle", class_="label"
        )
        return element("g", element("path", d=lines, class_="grid"), texts, name)

    def _ticks_of_y(self, label: str) -> Markup:
        values = ticks(*self.y)
        places = self.at(np.column_stack([np.full(len(values), self.x[0]), values]))[:, 1]
        lines = "".join(f"M{_LEFT} {place:.1f}h{self.width:.1f}" for place in places)
        texts = [
            element("text", _tick(value), x=_LEFT - 6.0, y=place + 4.0, text_anchor="end")
            for value, place in zip(values, places, strict=True)
        ]
        middle = _TOP + self.height / 2.0
        turned = f"translate(13 {middle:.1f}) rotate(-90)"
        name = element("text", label, transform=turned, text_anchor="middle", class_="label")
        return element("g", element("path", d=lines, class_="grid"), texts, name)


def ticks(low: float, high: float) -> FloatArray:
    """Return round numbers within a range, some six of them.

    Examples
    --------
    >>> ticks(-0.2, 2047.0).tolist()
    [0.0, 500.0, 1000.0, 1500.0, 2000.0]
    """
    step = round_step((high - low) / _TICKS)
    first = np.ceil(low / step - 1e-9)
    return np.asarray(np.arange(first, np.floor(high / step + 1e-9) + 1.0) * step + 0.0)


def round_step(step: float) -> float:
    """Return the next 1, 2 or 5 times a power of ten that is not smaller.

    Examples
    --------
    >>> round_step(0.013), round_step(341.0)
    (0.02, 500.0)
    """
    decade = 10.0 ** float(np.floor(np.log10(step)))
    return next(float(each * decade) for each in (1, 2, 5, 10) if each * decade >= step * 0.999)


def _tick(value: float) -> str:
    return minus(f"{value:g}")


def line_through(points: FloatArray) -> str:
    """Return the ``d`` of a path through points, shape (N, 2)."""
    return "M" + "L".join(f"{x:.2f} {y:.2f}" for x, y in points) if len(points) else ""


def specks(points: FloatArray) -> str:
    """Return the ``d`` of a path of single points, seen where its line has round ends."""
    return "".join(f"M{x:.1f} {y:.1f}h0" for x, y in points)


def needles(starts: FloatArray, lengths: FloatArray) -> str:
    """Return the ``d`` of a path of needles from points along vectors, both shape (N, 2)."""
    return "".join(
        f"M{x:.1f} {y:.1f}l{dx:.1f} {dy:.1f}"
        for (x, y), (dx, dy) in zip(starts, lengths, strict=True)
    )
