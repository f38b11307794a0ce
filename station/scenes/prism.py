"""A prism over an open profile: where lines of sight meet it, and what lies in its own shadow."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from calib import BoolArray, FloatArray
from measure import PieceFace

_CLEAR_MM = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class Prism:
    """Faces in x and z, drawn out along y, about the origin; its ends are open.

    Attributes
    ----------
    faces
        Its sides, metal on the right of their way.
    length_mm
        Along y.
    """

    faces: Sequence[PieceFace]
    length_mm: float

    def met(
        self, eye_mm: FloatArray, sight: FloatArray
    ) -> tuple[FloatArray, FloatArray, BoolArray]:
        """Return where lines from an eye first meet a side from outside.

        Parameters
        ----------
        eye_mm
            Shape (3,).
        sight
            Shape (..., 3), any length.

        Returns
        -------
        points_mm, normals
            Shape (..., 3); meaningless where nothing is met.
        seen
            Shape (...).
        """
        nearest = np.full(sight.shape[:-1], np.inf)
        normals = np.zeros_like(sight)
        for face in self.faces:
            for depth in _depths(face, eye_mm[[0, 2]], sight[..., [0, 2]]):
                met = eye_mm + np.where(np.isfinite(depth), depth, 0.0)[..., None] * sight
                along, _ = face.place(met[..., [0, 2]].reshape(-1, 2))
                _, out = face.points(along)
                along, out = along.reshape(depth.shape), out.reshape(*depth.shape, 2)
                here = np.isfinite(depth) & (depth > 0.0) & (depth < nearest)
                here &= (along >= 0.0) & (along <= face.length_mm)
                here &= np.abs(met[..., 1]) <= 0.5 * self.length_mm
                here &= (out * sight[..., [0, 2]]).sum(axis=-1) < 0.0
                nearest[here] = depth[here]
                normals[here] = np.stack([out[..., 0], np.zeros_like(depth), out[..., 1]], -1)[here]
        seen = np.isfinite(nearest)
        return eye_mm + np.where(seen, nearest, 0.0)[..., None] * sight, normals, seen

    def shaded(self, source_mm: FloatArray, points_mm: FloatArray) -> BoolArray:
        """Tell which points, shape (N, 3), of its surface the light of a source cannot reach.

        The prism counts as endless.
        """
        source = source_mm[[0, 2]]
        beam = points_mm[:, [0, 2]] - source
        clear = 1.0 - _CLEAR_MM / np.linalg.norm(beam, axis=1)
        shaded = np.zeros(len(points_mm), dtype=bool)
        for face in self.faces:
            for depth in _depths(face, source, beam):
                finite = np.where(np.isfinite(depth), depth, 0.0)
                along, _ = face.place(source + finite[:, None] * beam)
                on = (along >= 0.0) & (along <= face.length_mm)
                shaded |= on & np.isfinite(depth) & (depth > 0.0) & (depth < clear)
        return shaded


def _depths(face: PieceFace, eye_mm: FloatArray, sight: FloatArray) -> list[FloatArray]:
    """Return at which multiples of the sight lines meet the endless side; not finite: never."""
    with np.errstate(divide="ignore", invalid="ignore"):
        if face.centre_mm is None:
            off = float((face.start_mm - eye_mm) @ face.normal)
            return [off / (sight @ face.normal)]
        arm = eye_mm - face.centre_mm
        a = (sight**2).sum(axis=-1)
        b = sight @ arm
        root = np.sqrt(b * b - a * (float(arm @ arm) - face.radius_mm**2))
        return [(-b - root) / a, (-b + root) / a]
