r"""Normal equations of views that share nothing but the global parameters.

The normal matrix is an arrow: a 6 x 6 block per view, a border, and the global block. Eliminating
the views (the Schur complement) leaves a system as large as the global block alone, so the cost
grows linearly with the views.

.. math:: \begin{pmatrix} U_v & X_v \\ X_v^T & G \end{pmatrix}
          \begin{pmatrix} p_v \\ g \end{pmatrix} = \begin{pmatrix} b_v \\ b_g \end{pmatrix},
          \quad S = G - \sum_v X_v^T U_v^{-1} X_v
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from calib.arrays import FloatArray, IntArray
from calib.errors import NotConverged
from calib.solving.joint.parameters import POSE_SIZE
from calib.solving.joint.residuals import Linear


@dataclass(frozen=True, slots=True, eq=False)
class NormalEquations:
    """The arrow matrix, its right side, and the cost they were made at.

    Attributes
    ----------
    views
        U, shape (M, 6, 6).
    border
        X, shape (M, 6, G).
    shared
        G, shape (G, G).
    views_side, shared_side
        Right sides, shapes (M, 6) and (G,).
    cost
        Half the weighted sum of squares.
    """

    views: FloatArray
    border: FloatArray
    shared: FloatArray
    views_side: FloatArray
    shared_side: FloatArray
    cost: float

    @classmethod
    def of(cls, linear: Linear, weights: FloatArray, view: IntArray, count: int) -> Self:
        """Sum up one kind of point.

        Parameters
        ----------
        linear
            Residuals and Jacobian of N points.
        weights
            Shape (N,), of the squares.
        view, count
            Index of the view of each point, ascending; how many views there are.
        """
        rows, columns = linear.jacobian.shape[1:]
        table = np.empty((len(view), rows, columns + 1))
        root = np.sqrt(weights)[:, None]
        table[:, :, :columns] = linear.jacobian * root[:, :, None]
        table[:, :, columns] = linear.residual * root
        edges = np.searchsorted(view, np.arange(count + 1))
        squares = np.empty((count, columns + 1, columns + 1))
        for index in range(count):
            part = table[edges[index] : edges[index + 1]].reshape(-1, columns + 1)
            squares[index] = part.T @ part
        pose, shared = slice(0, POSE_SIZE), slice(POSE_SIZE, columns)
        return cls(
            views=squares[:, pose, pose],
            border=squares[:, pose, shared],
            shared=squares[:, shared, shared].sum(axis=0),
            views_side=squares[:, pose, columns],
            shared_side=squares[:, shared, columns].sum(axis=0),
            cost=float(squares[:, columns, columns].sum()) / 2.0,
        )

    def __add__(self, other: "NormalEquations") -> "NormalEquations":
        return NormalEquations(
            self.views + other.views,
            self.border + other.border,
            self.shared + other.shared,
            self.views_side + other.views_side,
            self.shared_side + other.shared_side,
            self.cost + other.cost,
        )

    def with_prior(self, information: FloatArray, gap: FloatArray) -> "NormalEquations":
        """Add a prior on the global block: information (G, G), prior minus state (G,)."""
        return NormalEquations(
            self.views,
            self.border,
            self.shared + information,
            self.views_side,
            self.shared_side + information @ gap,
            self.cost + float(gap @ information @ gap) / 2.0,
        )

    def step(self, damping: float) -> tuple[FloatArray, FloatArray, float]:
        """Solve for the step, the diagonal raised by the factor 1 + damping.

        Returns
        -------
        global_step, pose_steps
            Shapes (G,) and (M, 6).
        decrement
            Right side times step: the squared length of the step in standard deviations.

        Raises
        ------
        NotConverged
            If the matrix is singular.
        """
        views = _inverse(_raised(self.views, damping))
        by_side = np.einsum("vij,vj->vi", views, self.views_side)
        by_border = views @ self.border
        schur = _raised(self.shared, damping) - _folded(self.border, by_border)
        side = self.shared_side - np.einsum("vij,vi->j", self.border, by_side)
        global_step = _solve_scaled(schur, side)
        pose_steps = by_side - by_border @ global_step
        decrement = global_step @ self.shared_side + (pose_steps * self.views_side).sum()
        return global_step, pose_steps, float(decrement)

    def covariance(self) -> "ArrowCovariance":
        """Return the blocks of the inverse.

        Raises
        ------
        NotConverged
            If the matrix is singular.
        """
        views = _inverse(self.views)
        by_border = views @ self.border
        schur = self.shared - _folded(self.border, by_border)
        shared = _solve_scaled(schur, np.eye(len(schur)))
        shared = (shared + shared.T) / 2.0
        cross = -by_border @ shared
        return ArrowCovariance(views - cross @ by_border.transpose(0, 2, 1), cross, shared)


@dataclass(frozen=True, slots=True, eq=False)
class ArrowCovariance:
    """Blocks of the inverse of the arrow matrix.

    Attributes
    ----------
    views
        Covariance of each pose, shape (M, 6, 6).
    cross
        Between each pose and the global block, shape (M, 6, G).
    shared
        Of the global block, shape (G, G).
    """

    views: FloatArray
    cross: FloatArray
    shared: FloatArray

    def of_view(self, view: int) -> FloatArray:
        """Return the covariance of one pose and the global block, shape (6 + G, 6 + G)."""
        cross = self.cross[view]
        return np.block([[self.views[view], cross], [cross.T, self.shared]])

    def freedom_spent_on(self, part: NormalEquations) -> float:
        """Return the degrees of freedom that one kind of point pays: trace of inverse times part.

        The kinds' shares add up to the number of parameters [1]_.

        References
        ----------
        .. [1] W. Foerstner, "Ein Verfahren zur Schaetzung von Varianz- und Kovarianzkomponenten",
           Allgemeine Vermessungs-Nachrichten 86, 1979.
        """
        return float(
            np.einsum("vij,vji->", self.views, part.views)
            + 2.0 * np.einsum("vij,vij->", self.cross, part.border)
            + np.einsum("ij,ji->", self.shared, part.shared)
        )


def _folded(border: FloatArray, by_border: FloatArray) -> FloatArray:
    """Return the sum over the blocks of border^T by_border, shape (G, G)."""
    # One product of two flat matrices; einsum would take ten times as long.
    return np.asarray(np.tensordot(border, by_border, axes=((0, 1), (0, 1))))


def _raised(matrices: FloatArray, damping: float) -> FloatArray:
    diagonal = np.einsum("...ii->...i", matrices)
    return np.asarray(matrices + damping * diagonal[..., None] * np.eye(matrices.shape[-1]))


def _inverse(views: FloatArray) -> FloatArray:
    """Invert the blocks of the poses, shape (M, 6, 6)."""
    # A radian and a millimetre move a point by as much as 1e3 to 1.
    scale = 1.0 / np.sqrt(np.einsum("vii->vi", views))
    square = scale[:, :, None] * scale[:, None, :]
    try:
        return np.asarray(np.linalg.inv(views * square) * square)
    except np.linalg.LinAlgError as error:
        raise _undetermined("a pose") from error


def _undetermined(what: str) -> NotConverged:
    return NotConverged(
        f"the pictures do not determine {what}; add pictures of the target in other places and "
        "tilts"
    )


def _solve_scaled(matrix: FloatArray, side: FloatArray) -> FloatArray:
    """Solve a symmetric system whose unknowns differ widely in size (fx 2000 px, k2 0.1)."""
    if len(matrix) == 0:
        return side
    diagonal = np.diag(matrix)
    if not (diagonal > 0.0).all():
        raise _undetermined("camera and light plane")
    scale = 1.0 / np.sqrt(diagonal)
    rows = scale if side.ndim == 1 else scale[:, None]
    try:
        return np.asarray(np.linalg.solve(matrix * scale * scale[:, None], side * rows) * rows)
    except np.linalg.LinAlgError as error:
        raise _undetermined("camera and light plane") from error
