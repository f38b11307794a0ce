"""How well the sheet is known over the field: σ of a point in mm, drawn on the sheet itself."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from calib import FloatArray, IntArray, LaserSensor
from station.documents import CalibrationDocument
from station.report.drawing import Axes, line_through, specks
from station.report.evidence import PictureEvidence
from station.report.markup import Markup, element, figure, join, section
from station.report.wording import figures

_CELLS_ACROSS = 120
_ROWS_A_CELL = 2
"""The sheet changes most along v: cells are lower than wide."""
_STRIDE = 5
"""Cells of one shade in a row are drawn as one, with a corner every so many: lenses bend lines."""
_MARGIN = 0.05
"""How far the map reaches beyond the stripes seen, as part of the picture's width."""
_SHADES = 7
_NO_SHEET = -1
_WIDTH = 720.0


@dataclass(frozen=True, slots=True, eq=False)
class SheetFrame:
    """Axes within the sheet, mm: x as pictures run to the right, y as they run down."""

    origin_in_cam_mm: FloatArray
    axes: FloatArray
    """Shape (2, 3), unit, in the camera frame."""

    @classmethod
    def at(cls, sensor: LaserSensor, pixel_px: FloatArray) -> "SheetFrame":
        """Make the axes with their origin where a pixel, shape (2,), sees the sheet."""
        here, right, down = sensor.locate(pixel_px + np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]))
        x = (right - here) / np.linalg.norm(right - here)
        y = np.cross(sensor.plane.normal_in_cam, x)
        y *= np.sign(y @ (down - here))
        return cls(here, np.vstack([x, y]))

    def place(self, points_in_cam_mm: FloatArray) -> FloatArray:
        """Return points on the sheet, shape (..., 3), along its axes, shape (..., 2), mm."""
        return np.asarray((points_in_cam_mm - self.origin_in_cam_mm) @ self.axes.T)


def sheet_map(document: CalibrationDocument, pictures: Sequence[PictureEvidence]) -> Markup:
    """Return the map of the sheet's σ, or a line where no stripe tells where to draw it."""
    seen_px = _stripes_px(pictures)
    if not len(seen_px):
        return section("Uncertainty over the field", element("p", "No stripe point was used."))
    sensor = document.laser_sensor()
    corners_px, centres_px = _cells(document, seen_px)
    frame = SheetFrame.at(sensor, np.median(seen_px, axis=0))
    corners_mm = frame.place(sensor.locate(corners_px.reshape(-1, 2)).reshape(-1, 4, 3))
    sigma_mm = sensor.sigma_on_sheet(centres_px)
    sigma_mm[~np.isfinite(corners_mm).all(axis=(1, 2))] = np.nan
    levels_mm = _levels(sigma_mm)
    drawing = _draw(corners_mm, sigma_mm, levels_mm, frame.place(sensor.locate(seen_px)))
    at_stripes_mm = sensor.sigma_on_sheet(seen_px)
    caption = (
        "One standard deviation of a point on the sheet, along its worst direction, as far as the "
        "calibration itself causes it (the noise of a single stripe point comes on top). Dots: "
        "the stripe points used. There it is between "
        f"{figures(float(np.nanmin(at_stripes_mm)))} and {figures(float(np.nanmax(at_stripes_mm)))}"
        " mm. Away from the dots the sheet is extrapolated. Axes lie in the sheet: x as the "
        "picture runs to the right, y as it runs down."
    )
    return section(
        "Uncertainty over the field", figure(join([_scale(levels_mm), drawing]), caption)
    )


def _stripes_px(pictures: Sequence[PictureEvidence]) -> FloatArray:
    parts = [picture.stripe.corrected_px[picture.stripe.used] for picture in pictures]
    return np.vstack([np.empty((0, 2)), *parts])


def _cells(document: CalibrationDocument, seen_px: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return corners, shape (N, 4, 2), and centres, shape (N, 2), of cells around the stripes."""
    size = np.array([document.camera.width, document.camera.height], dtype=np.float64)
    margin = _MARGIN * size[0]
    low = np.clip(seen_px.min(axis=0) - margin, 0.0, size - 1.0)
    high = np.clip(seen_px.max(axis=0) + margin, low + 1.0, size)
    step = (high - low)[0] / _CELLS_ACROSS
    rows = max(1, round(_ROWS_A_CELL * float((high - low)[1] / step)))
    u = np.linspace(low[0], high[0], _CELLS_ACROSS + 1)
    v = np.linspace(low[1], high[1], rows + 1)
    grid = np.stack(np.meshgrid(u, v), axis=-1)
    around = (grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1])
    corners = np.stack(around, axis=2).reshape(-1, 4, 2)
    return corners, corners.mean(axis=1)


def _runs(shade: IntArray) -> Iterator[tuple[int, int]]:
    """Yield first and last of neighbouring cells in a row that have one shade."""
    first = 0
    for cell in range(1, len(shade) + 1):
        if cell == len(shade) or shade[cell] != shade[first] or cell % _CELLS_ACROSS == 0:
            yield first, cell - 1
            first = cell


def _outline(places: FloatArray, first: int, last: int) -> FloatArray:
    """Return the corners, shape (N, 2), around neighbouring cells of a row."""
    # The same columns in every row, so that rows meet without a gap.
    between = [cell for cell in range(first + 1, last + 1) if cell % _STRIDE == 0]
    along = [first, *between]
    top = [*places[along, 0], places[last, 1]]
    bottom = [*places[along, 3], places[last, 2]]
    return np.array([*top, *bottom[::-1]])


def _levels(sigma_mm: FloatArray) -> FloatArray:
    """Return the bounds of the shades, mm: round numbers."""
    low, high = float(np.nanmin(sigma_mm)), float(np.nanmax(sigma_mm))
    step = _level_step(max((high - low) / (_SHADES - 1), 1e-9))
    first = np.floor(low / step)
    return np.asarray((first + np.arange(_SHADES + 1)) * step)


def _level_step(step: float) -> float:
    """Return the next number with one digit, or a quarter of a decade, that is not smaller."""
    decade = 10.0 ** float(np.floor(np.log10(step)))
    steps = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
    return float(min(each * decade for each in steps if each * decade >= 0.999 * step))


def _draw(
    corners_mm: FloatArray, sigma_mm: FloatArray, levels_mm: FloatArray, stripes_mm: FloatArray
) -> Markup:
    low, high = np.nanmin(corners_mm, axis=(0, 1)), np.nanmax(corners_mm, axis=(0, 1))
    axes = Axes.same_scale((low[0], high[0]), (low[1], high[1]), _WIDTH, down=True)
    places = axes.at(corners_mm.reshape(-1, 2)).reshape(-1, 4, 2)
    shade = np.clip(np.searchsorted(levels_mm, sigma_mm, side="right") - 1, 0, _SHADES - 1)
    shade[np.isnan(sigma_mm)] = _NO_SHEET
    shapes: dict[int, list[str]] = {each: [] for each in range(_SHADES)}
    for first, last in _runs(shade):
        if shade[first] != _NO_SHEET:
            shapes[int(shade[first])].append(f"{line_through(_outline(places, first, last))}z")
    cells = [
        element("path", d="".join(outlines), class_=f"shade-{each}")
        for each, outlines in shapes.items()
        if outlines
    ]
    stripes = element("path", d=specks(axes.at(stripes_mm)), class_="stripes-on-map")
    return axes.drawing(
        "Map of the uncertainty over the sheet", "x on the sheet, mm", "y on the sheet, mm",
        cells, stripes,
    )  # fmt: skip


def _scale(levels_mm: FloatArray) -> Markup:
    """Draw the shades with their bounds."""
    wide, tall = 60.0, 16.0
    step_mm = float(levels_mm[1] - levels_mm[0])
    decimals = next(d for d in range(12) if abs(round(step_mm, d) - step_mm) < 0.01 * step_mm)
    boxes = [
        element("rect", x=20.0 + each * wide, y=0.0, width=wide, height=tall,
                class_=f"shade-{each}")
        for each in range(_SHADES)
    ]  # fmt: skip
    texts = [
        element("text", f"{level:.{decimals}f}", x=20.0 + place * wide, y=tall + 14.0,
                text_anchor="middle")
        for place, level in enumerate(levels_mm.tolist())
    ]  # fmt: skip
    unit = element("text", "σ, mm", x=30.0 + _SHADES * wide + 18.0, y=tall - 3.0, class_="label")
    return element(
        "svg", boxes, texts, unit,
        viewBox=f"0 0 {90.0 + _SHADES * wide:g} {tall + 18.0:g}", class_="scale", role="img",
        aria_label="Scale of the map",
    )  # fmt: skip
