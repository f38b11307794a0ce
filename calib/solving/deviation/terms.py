"""A sum of distances: one of the paper's objective functions, with its derivatives."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array

from calib.arrays import FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Derivatives of K differences by c unknowns each.

    Attributes
    ----------
    columns
        Shape (K, c), which unknowns.
    values
        Shape (K, d, c).
    """

    columns: IntArray
    values: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Distances:
    """K differences of d coordinates whose lengths are summed.

    Attributes
    ----------
    difference
        Shape (K, d).
    blocks
        Its derivatives; unknowns without a block leave it alone.
    blunt
        Lengths below this count by their square, so that the sum is smooth at zero.
    wide
        A difference owes to a whole picture, not to a few points.
    """

    difference: FloatArray
    blocks: tuple[Block, ...]
    blunt: float
    wide: bool = False

    @property
    def cost(self) -> float:
        """The sum of the lengths, each blunted near zero (Huber's loss over `blunt`)."""
        length = self._length
        near = 0.5 * length**2 / self.blunt
        return float(np.where(length < self.blunt, near, length - 0.5 * self.blunt).sum())

    def rows(self, size: int) -> tuple[coo_array, FloatArray]:
        """Return the Jacobian, shape (K d, size), and the differences, (K d,), whitened.

        Half their squares have the value of `cost` less what does not move, and its slope.
        """
        count, width = self.difference.shape
        root = 1.0 / np.sqrt(np.maximum(self._length, self.blunt))
        index = np.arange(count * width).reshape(count, width, 1)
        rows, columns, values = [], [], []
        for block in self.blocks:
            shape = block.values.shape
            rows.append(np.broadcast_to(index, shape).ravel())
            columns.append(np.broadcast_to(block.columns[:, None, :], shape).ravel())
            values.append((block.values * root[:, None, None]).ravel())
        jacobian = coo_array(
            (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
            shape=(count * width, size),
        )
        return jacobian, (self.difference * root[:, None]).ravel()

    @property
    def _length(self) -> FloatArray:
        return np.asarray(np.linalg.norm(self.difference, axis=1))
