"""Many small windows of a picture at once."""

from dataclasses import dataclass, replace

import numpy as np

from calib.arrays import BoolArray, FloatArray, IntArray, Picture
from calib.seeing.noise import SATURATED_FROM, PixelNoise
from calib.seeing.resample import Float32Array


@dataclass(frozen=True, slots=True, eq=False)
class Patches:
    """Pixels of N windows.

    Attributes
    ----------
    origin
        Shape (N, 2), whole pixels.
    offset
        Shape (K, 2), whole pixels from each origin.
    samples
        Shape (N, K), counts.
    weight
        Shape (N, K), 0 where a pixel is not to be used, else 1 / variance.
    clipped
        Shape (N, K), the sensor's limit.
    """

    origin: IntArray
    offset: IntArray
    samples: Float32Array
    weight: Float32Array
    clipped: BoolArray

    @classmethod
    def cut(
        cls,
        picture: Picture,
        smooth: Picture,
        noise: PixelNoise,
        origin: IntArray,
        offset: IntArray,
        use: BoolArray,
    ) -> "Patches":
        """Cut windows; what lies outside the picture is not used.

        `smooth` is the picture a little smoothed: a weight that followed a pixel's own noise
        would favour the dim.
        """
        u = origin[:, 0, None] + offset[:, 0]
        v = origin[:, 1, None] + offset[:, 1]
        height, width = picture.shape
        inside = (u >= 0) & (v >= 0) & (u < width) & (v < height)
        u, v = np.clip(u, 0, width - 1), np.clip(v, 0, height - 1)
        samples = picture[v, u].astype(np.float32)
        variance = noise.variance(np.arange(256.0)).astype(np.float32)
        weight = np.where(use & inside, 1.0 / variance[smooth[v, u]], np.float32(0.0))
        return cls(origin, offset, samples, weight, samples >= SATURATED_FROM)

    def without(self, hidden: BoolArray) -> "Patches":
        """Return the same with the pixels of a mask, shape (N, K), not used."""
        return replace(self, weight=np.where(hidden, np.float32(0.0), self.weight))

    def picked(self, index: IntArray) -> "Patches":
        """Return some of the windows."""
        if index.size == len(self.origin):
            return self
        return Patches(
            self.origin[index],
            self.offset,
            self.samples[index],
            self.weight[index],
            self.clipped[index],
        )

    def places_px(self) -> FloatArray:
        """Return where the pixels are in the picture, shape (N, K, 2)."""
        return (self.origin[:, None, :] + self.offset).astype(np.float64)

    def cut_out(self, picture: Picture) -> tuple[Picture, IntArray]:
        """Return the part of the picture that holds all windows, and its corner (u, v)."""
        margin = int(np.abs(self.offset).max()) + 8
        limit = np.array(picture.shape)[::-1]
        low = np.clip(self.origin.min(axis=0) - margin, 0, limit - 1)
        high = np.clip(self.origin.max(axis=0) + margin + 1, low + 1, limit)
        return picture[low[1] : high[1], low[0] : high[0]], low

    def of(self, part: Float32Array, corner: IntArray) -> Float32Array:
        """Return the same pixels, shape (N, K), of a picture whose corner is elsewhere."""
        u = self.origin[:, 0, None] + self.offset[:, 0] - corner[0]
        v = self.origin[:, 1, None] + self.offset[:, 1] - corner[1]
        v, u = np.clip(v, 0, part.shape[0] - 1), np.clip(u, 0, part.shape[1] - 1)
        return np.asarray(part[v, u])


def masked_median(values: FloatArray | Float32Array, use: BoolArray) -> FloatArray:
    """Return the median of each row, shape (N,), over the entries used; 0 where none is."""
    ordered = np.sort(np.where(use, values, np.inf), axis=1)
    count = use.sum(axis=1)
    middle = ordered[np.arange(len(values)), np.maximum(count - 1, 0) // 2]
    return np.where(count > 0, middle, 0.0)
