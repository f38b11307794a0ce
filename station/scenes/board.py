"""What a calibration target looks like: where it glows, what light it returns, where it ends."""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from calib import FloatArray, Target, frozen
from station.scenes.patch import Counts
from station.scenes.texture import brushed

_TEXEL_MM = 0.25
_TEXELS = 512
_GRAIN_START_MM = 20.0  # the tile is mirrored beyond its ends; the first end lies off the board
_BOARD_SEED = 7 * 8 * 12  # one target for all pictures: its grain and its lamps do not change


@dataclass(frozen=True, slots=True)
class BoardMap:
    """The place on the board that each pixel of a window sees, mm, and its slope per pixel.

    Attributes
    ----------
    x_mm, y_mm
        Shape (rows, columns), TCF.
    x_per_px, y_per_px
        Shape (2, rows, columns): derivatives along the rows' and the columns' axis.
    """

    x_mm: Counts
    y_mm: Counts
    x_per_px: Counts
    y_per_px: Counts

    @classmethod
    def of(cls, x_mm: Counts, y_mm: Counts) -> "BoardMap":
        """Make the map of the places themselves."""
        return cls(x_mm, y_mm, np.array(np.gradient(x_mm)), np.array(np.gradient(y_mm)))

    def filled(
        self, inside_mm: Counts, toward_x: Counts | np.float32, toward_y: Counts | np.float32
    ) -> Counts:
        """Return the share of each pixel that lies inside an edge.

        Parameters
        ----------
        inside_mm
            Distance from the edge, positive inside.
        toward_x, toward_y
            Unit direction on the board in which that distance changes.

        Notes
        -----
        The distance in pixels is the distance on the board over its change per pixel. A straight
        edge there cuts the square of the pixel into two, whose areas `_cut_square` gives.
        """
        along_v = toward_x * self.x_per_px[0] + toward_y * self.y_per_px[0]
        along_u = toward_x * self.x_per_px[1] + toward_y * self.y_per_px[1]
        per_px = np.sqrt(along_u * along_u + along_v * along_v)
        distance_px = inside_mm / per_px
        share = (distance_px > 0.0).astype(np.float32)
        near = np.abs(distance_px) < np.float32(0.75)
        tilt_u, tilt_v = np.abs(along_u[near] / per_px[near]), np.abs(along_v[near] / per_px[near])
        share[near] = _cut_square(distance_px[near], tilt_u, tilt_v)
        return np.asarray(share)


@dataclass(frozen=True, slots=True)
class Appearance:
    """The surface each pixel sees; every field has the shape of the window.

    Attributes
    ----------
    board
        Share of the pixel that the board fills.
    lamps
        Light of its own, 1 for a lit dot of nominal brightness.
    white
        Share of daylight returned.
    metal
        How much of it is bare metal, which shines.
    laser
        Laser light returned, 1 for the metal of the target.
    grain
        Texture of the metal, mean 0, standard deviation 1.
    """

    board: Counts
    lamps: Counts
    white: Counts
    metal: Counts
    laser: Counts
    grain: Counts


def outline_mm(target: Target) -> NDArray[np.float64]:
    """Return the lower and upper end of the board in TCF, shape (2, 2), x first."""
    margin = target.pitch_mm * (1.5 if target.kind == "chessboard" else 1.0)
    last = np.array([target.cols - 1, target.rows - 1]) * target.pitch_mm
    return np.array([[-margin, -margin], last + margin])


def dot_radius_mm(target: Target) -> float:
    """Return the radius of the target's dots; half the pitch across where none is given."""
    return (target.diameter_mm or target.pitch_mm / 2.0) / 2.0


def checked_shifts(target: Target, dot_shift_mm: FloatArray) -> FloatArray:
    """Return the shifts of a target's dots, read-only, shape (rows * cols, 2).

    Raises
    ------
    ValueError
        If the target has no dots, there is not a shift for each, or dots may touch.
    """
    shifts = frozen(dot_shift_mm, (target.rows * target.cols, 2), "dot_shift_mm")
    if target.kind != "dots":
        raise ValueError(f"only dots can be displaced, and the target is {target}")
    gap_mm = 0.5 * target.pitch_mm - dot_radius_mm(target)
    largest_mm = float(np.abs(shifts).max())
    if not largest_mm < gap_mm:
        raise ValueError(f"dots displaced by {largest_mm:g} mm; allowed: less than {gap_mm:g}")
    return shifts


def appearance(
    target: Target,
    place: BoardMap,
    grain_contrast: float,
    dot_shift_mm: FloatArray | None = None,
) -> Appearance:
    """Return what a window sees of the target.

    Parameters
    ----------
    target
        Lit dots on dark metal, dark dots printed on white, or a chessboard.
    place
        Where on the board its pixels look.
    grain_contrast
        Standard deviation over mean of what the bare board returns.
    dot_shift_mm
        Shape (rows * cols, 2): how far each dot is from its place, less than half of the gap
        between dots.
    """
    grain = _grain(place)
    if target.kind == "chessboard" or target.dark:
        return _printed(target, place, grain, grain_contrast, dot_shift_mm)
    dot, lamps = _dots(target, place, dot_shift_mm)
    metal = 1.0 - dot
    returned = 1.0 + np.float32(grain_contrast) * grain
    return Appearance(
        board=_board_share(target, place),
        lamps=lamps,
        white=np.asarray(0.3 * metal * returned + 0.5 * dot, dtype=np.float32),
        metal=metal,
        # A diffuser scatters the laser back twice as well as dark metal.
        laser=np.asarray(metal * returned + 2.0 * dot, dtype=np.float32),
        grain=grain,
    )


def _printed(
    target: Target,
    place: BoardMap,
    grain: Counts,
    grain_contrast: float,
    dot_shift_mm: FloatArray | None,
) -> Appearance:
    """Return what a window sees of ink on paper: nothing glows and nothing shines."""
    if target.kind == "chessboard":
        ink = _chessboard(target, place)
    else:
        ink, _ = _dots(target, place, dot_shift_mm)
    paper = 1.0 + np.float32(0.3 * grain_contrast) * grain
    nothing = np.zeros(ink.shape, dtype=np.float32)
    return Appearance(
        board=_board_share(target, place),
        lamps=nothing,
        white=np.asarray((0.8 - 0.74 * ink) * paper, dtype=np.float32),
        metal=nothing,
        laser=np.asarray((1.6 - 1.2 * ink) * paper, dtype=np.float32),
        grain=grain,
    )


def _cut_square(distance: Counts, tilt_u: Counts, tilt_v: Counts) -> Counts:
    """Return the area of a unit square on one side of a line.

    Parameters
    ----------
    distance
        Of the line from the square's middle, positive where that lies inside.
    tilt_u, tilt_v
        Absolute components of the line's unit normal.
    """
    steep, flat = np.maximum(tilt_u, tilt_v), np.minimum(tilt_u, tilt_v)
    far = np.abs(distance)
    # The line cuts two opposite sides of the square, or it cuts off a corner: a triangle.
    trapezoid = 0.5 - far / steep
    to_corner = np.maximum(0.5 * (steep + flat) - far, 0.0)
    triangle = to_corner**2 / np.maximum(2.0 * steep * flat, np.float32(1e-12))
    outside = np.where(far <= 0.5 * (steep - flat), trapezoid, triangle)
    return np.asarray(np.where(distance > 0.0, 1.0 - outside, outside), dtype=np.float32)


def _board_share(target: Target, place: BoardMap) -> Counts:
    low, high = outline_mm(target)
    one, zero = np.float32(1.0), np.float32(0.0)
    x_inside = np.minimum(place.x_mm - np.float32(low[0]), np.float32(high[0]) - place.x_mm)
    y_inside = np.minimum(place.y_mm - np.float32(low[1]), np.float32(high[1]) - place.y_mm)
    return place.filled(x_inside, one, zero) * place.filled(y_inside, zero, one)


def _dots(
    target: Target, place: BoardMap, dot_shift_mm: FloatArray | None
) -> tuple[Counts, Counts]:
    """Return the share of each pixel that a dot fills, and the dot's light."""
    pitch = np.float32(target.pitch_mm)
    col = np.clip(np.rint(place.x_mm / pitch), 0, target.cols - 1)
    row = np.clip(np.rint(place.y_mm / pitch), 0, target.rows - 1)
    x, y = place.x_mm - col * pitch, place.y_mm - row * pitch
    if dot_shift_mm is not None:
        which = (row * target.cols + col).astype(np.intp)
        x, y = np.asarray([x, y]) - dot_shift_mm.astype(np.float32).T[:, which]
    distance = np.sqrt(x * x + y * y) + np.float32(1e-6)
    radius = np.float32(dot_radius_mm(target))
    dot = place.filled(radius - distance, x / distance, y / distance)
    # A diffuser over one LED is a little brighter in its middle, and no two LEDs are alike.
    lamp = _lamps(target.rows, target.cols)[row.astype(np.intp), col.astype(np.intp)]
    falling = 1.0 - 0.1 * np.minimum(distance / radius, 1.0) ** 2
    return dot, np.asarray(dot * lamp * falling, dtype=np.float32)


def _chessboard(target: Target, place: BoardMap) -> Counts:
    """Return the share of each pixel that is black; the corners are the target's points."""
    one, zero = np.float32(1.0), np.float32(0.0)
    pitch = np.float32(target.pitch_mm)
    wave_x = _square_wave(place.x_mm, pitch, place, one, zero)
    wave_y = _square_wave(place.y_mm, pitch, place, zero, one)
    low, high = -pitch, (np.array([target.cols, target.rows]) * pitch).astype(np.float32)
    x_inside = np.minimum(place.x_mm - low, high[0] - place.x_mm)
    y_inside = np.minimum(place.y_mm - low, high[1] - place.y_mm)
    squares = place.filled(x_inside, one, zero) * place.filled(y_inside, zero, one)
    return np.asarray(squares * (0.5 + 0.5 * wave_x * wave_y), dtype=np.float32)


def _square_wave(
    along_mm: Counts, pitch: np.float32, place: BoardMap, to_x: np.float32, to_y: np.float32
) -> Counts:
    """Return -1 and 1 by turns, changing over one pixel at every multiple of the pitch."""
    cell = np.floor(along_mm / pitch)
    to_line = np.minimum(along_mm - cell * pitch, (cell + 1.0) * pitch - along_mm)
    sign = 1.0 - 2.0 * np.mod(cell, 2.0)
    return np.asarray(sign * (2.0 * place.filled(to_line, to_x, to_y) - 1.0), dtype=np.float32)


def _grain(place: BoardMap) -> Counts:
    return np.asarray(
        cv2.remap(
            _grain_tile(),
            (place.x_mm + np.float32(_GRAIN_START_MM)) / np.float32(_TEXEL_MM),
            (place.y_mm + np.float32(_GRAIN_START_MM)) / np.float32(_TEXEL_MM),
            interpolation=cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REFLECT_101,
        )
    )


@lru_cache(maxsize=1)
def _grain_tile() -> Counts:
    tile = brushed(np.random.default_rng(_BOARD_SEED), (_TEXELS, _TEXELS))
    tile.setflags(write=False)
    return tile


@lru_cache(maxsize=8)
def _lamps(rows: int, cols: int) -> Counts:
    drawn = np.random.default_rng(_BOARD_SEED).normal(1.0, 0.04, (rows, cols))
    return np.clip(drawn, 0.85, 1.15).astype(np.float32)
