"""What a simulated camera looks at."""

from collections.abc import Callable, Sequence
from typing import Protocol, runtime_checkable

import numpy as np

from calib import Picture


class FrameSource(Protocol):
    """Gives the picture of each exposure.

    A picture handed out must not be changed afterwards: it is sent from another thread.
    """

    @property
    def width(self) -> int:
        """Width of every picture, px."""

    @property
    def height(self) -> int:
        """Height of every picture, px."""

    def frame(self, index: int, exposure_us: float) -> Picture:
        """Return the picture of one exposure.

        Parameters
        ----------
        index
            Exposures since the device started, from 0.
        exposure_us
            Exposure time times gain, µs: ten microseconds at 20 dB count as a hundred.

        Returns
        -------
        Picture
            Shape (height, width), uint8.
        """


@runtime_checkable
class LaserSwitched(Protocol):
    """A source whose laser can be switched off; others show the same with and without."""

    def frame_laser_off(self, index: int, exposure_us: float) -> Picture:
        """Return the picture of one exposure with the laser off; see `FrameSource.frame`."""


class ArraySource:
    """Serves given pictures one after another, over and over; the exposure changes nothing."""

    def __init__(self, frames: Sequence[Picture]) -> None:
        if not frames:
            raise ValueError("at least one picture is needed")
        shapes = {(frame.shape, frame.dtype.str) for frame in frames}
        if not (len(shapes) == 1 and frames[0].ndim == 2 and frames[0].dtype == np.uint8):
            raise ValueError(f"pictures must be uint8 of one shape (H, W), got {sorted(shapes)}")
        self._frames = tuple(frames)
        self.height, self.width = frames[0].shape

    def frame(self, index: int, exposure_us: float) -> Picture:
        return self._frames[index % len(self._frames)]


class SceneSource:
    """Serves what a function renders."""

    def __init__(self, render: Callable[[int, float], Picture], *, width: int, height: int) -> None:
        """Take ``render(index, exposure_us)``; see `FrameSource.frame`."""
        self._render = render
        self.width = width
        self.height = height

    def frame(self, index: int, exposure_us: float) -> Picture:
        return self._render(index, exposure_us)
