"""A turned body: where a sheet cuts it, what hides what, and what a ray meets first."""

from dataclasses import dataclass, field

import numpy as np

from calib import BoolArray, FloatArray, IntArray, LightPlane, RigidTransform
from station.scenes.wheel_truth import WheelProfile

_TABLE_STEP_MM = 0.02
# How far along a line of sight something may stand in the way: the flange is 30 mm high.
_SIGHT_MM = np.geomspace(0.3, 150.0, 48)
_INTO_MM = np.arange(0.0, 240.0, 8.0)
_ONWARD_STEP_MM = 1.5
_ONWARD_MM = np.arange(0.5, 110.0, _ONWARD_STEP_MM)
_SKIN_MM = 0.02  # a point on the surface does not hide itself for being rounded into it


@dataclass(frozen=True, slots=True, eq=False)
class Section:
    """The strip of surface around the line in which a sheet cuts the body.

    Rows of the grid follow the profile, columns go from one side of the sheet to the other.

    Attributes
    ----------
    points_in_cam_mm, normals_in_cam
        Shape (S, Q, 3).
    place
        Shape (S,): index of each row in the profile.
    """

    points_in_cam_mm: FloatArray
    normals_in_cam: FloatArray
    place: IntArray


@dataclass(frozen=True, slots=True, eq=False)
class Revolution:
    """A profile turned around an axle.

    Attributes
    ----------
    profile
        The outline; its z is counted from `radius_mm`.
    radius_mm
        Distance of z = 0 from the axle.
    cam_from_axle
        Pose of the axle: y along it as in the profile, origin on the axle at y = 0.
    """

    profile: WheelProfile
    radius_mm: float
    cam_from_axle: RigidTransform
    _table_start_mm: float = field(init=False)
    _radii_mm: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        y, z = self.profile.points_mm.T
        grid = np.arange(y.min(), y.max() + _TABLE_STEP_MM, _TABLE_STEP_MM)
        # The faces at both ends are upright: of their points only the outermost counts.
        first, last = int(np.argmax(y > y.min())) - 1, len(y) - int(np.argmax(y[::-1] < y.max()))
        front = slice(first, last + 1)
        radii = self.radius_mm + np.interp(grid, y[front], z[front])
        object.__setattr__(self, "_table_start_mm", float(grid[0]))
        object.__setattr__(self, "_radii_mm", radii)

    def section(self, plane: LightPlane, source_in_cam_mm: FloatArray, q_mm: FloatArray) -> Section:
        r"""Cut the body with a sheet and with its parallels.

        Parameters
        ----------
        plane
            The sheet, camera frame.
        source_in_cam_mm
            Shape (3,): of the two cuts through the body, the one on this side is taken.
        q_mm
            Shape (Q,): distances of the parallels from the sheet.

        Returns
        -------
        Section
            Points of the profile that the sheet does not reach are left out.

        Notes
        -----
        At a place y of the profile the body is a circle of radius r and the sheet a line at the
        distance h from the axle; they meet at :math:`\sqrt{r^2 - h^2}` along the line. No
        radial section is assumed.
        """
        lines = _SheetLines.of(plane, source_in_cam_mm, self.cam_from_axle)
        y, z = self.profile.points_mm.T
        radius = self.radius_mm + z
        height = lines.height_mm(y, q_mm)
        square = radius[:, None] ** 2 - height**2
        met = (square > 0.0).all(axis=1)
        height, square = height[met], square[met]
        flat = height[..., None] * lines.across + np.sqrt(square)[..., None] * lines.along
        points = _with_lateral(flat, y[met])
        n_y, n_z = self.profile.normals[met].T
        normals = _with_lateral(flat * (n_z / radius[met])[:, None, None], n_y)
        return Section(
            points_in_cam_mm=self.cam_from_axle.apply(points),
            normals_in_cam=normals @ self.cam_from_axle.rotation.T,
            place=np.flatnonzero(met),
        )

    def sees(self, points_in_cam_mm: FloatArray, eye_in_cam_mm: FloatArray) -> BoolArray:
        """Tell which points of the surface, shape (N, 3), can be seen from an eye, shape (3,)."""
        axle_from_cam = self.cam_from_axle.inverse()
        points = axle_from_cam.apply(points_in_cam_mm)
        sight = axle_from_cam.apply(eye_in_cam_mm[None])[0] - points
        sight /= np.linalg.norm(sight, axis=1, keepdims=True)
        on_sight = points[:, None, :] + _SIGHT_MM[:, None] * sight[:, None, :]
        return np.asarray(~(self._depth_inside_mm(on_sight) > _SKIN_MM).any(axis=1))

    def first_hit(self, rays_in_cam: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return where rays from the camera first meet the body, and the normal there.

        Parameters
        ----------
        rays_in_cam
            Shape (N, 3).

        Returns
        -------
        points_in_cam_mm, normals_in_cam
            Shape (N, 3) each, NaN where a ray passes by. Good to 0.1 mm: enough for what is
            shown out of focus; a stripe's place is never taken from it.
        """
        axle_from_cam = self.cam_from_axle.inverse()
        eye = axle_from_cam.translation_mm
        sight = rays_in_cam @ axle_from_cam.rotation.T
        sight /= np.linalg.norm(sight, axis=1, keepdims=True)
        start, passes = self._reach(eye, sight)
        near = np.flatnonzero(passes)
        travelled = start[near, None] + _INTO_MM
        inside = self._depth_inside_mm(eye + travelled[..., None] * sight[near, None, :]) > 0.0
        hit = inside.any(axis=1)
        near, first = near[hit], np.argmax(inside[hit], axis=1)
        far = travelled[hit, first]
        start_mm = np.broadcast_to(eye, (len(near), 3))
        points = np.full(rays_in_cam.shape, np.nan)
        normals = np.full(rays_in_cam.shape, np.nan)
        points[near], normals[near] = self._bisected(start_mm, sight[near], far - _INTO_MM[1], far)
        return points, normals

    def next_hit(
        self, points_in_cam_mm: FloatArray, ways_in_cam: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return where light that leaves the surface meets it again, and the normal there.

        Parameters
        ----------
        points_in_cam_mm, ways_in_cam
            Shape (N, 3): places on the surface and unit directions away from it.

        Returns
        -------
        points_in_cam_mm, normals_in_cam
            Shape (N, 3) each, NaN where the light goes off into the air. Good to 0.1 mm.
        """
        axle_from_cam = self.cam_from_axle.inverse()
        start = axle_from_cam.apply(points_in_cam_mm)
        ways = ways_in_cam @ axle_from_cam.rotation.T
        inside = self._depth_inside_mm(start[:, None] + _ONWARD_MM[:, None] * ways[:, None]) > 0.0
        hit = np.flatnonzero(inside.any(axis=1) & ~inside[:, 0])
        far = _ONWARD_MM[np.argmax(inside[hit], axis=1)]
        close = far - _ONWARD_STEP_MM
        points, normals = self._bisected(start[hit], ways[hit], close, far)
        met, there = np.full(start.shape, np.nan), np.full(start.shape, np.nan)
        met[hit], there[hit] = points, normals
        return met, there

    def _bisected(
        self, start: FloatArray, ways: FloatArray, close: FloatArray, far: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Return where ways from the axle frame enter the body between two distances, with normals.

        Both in the camera frame, shape (N, 3).
        """
        for _ in range(6):
            middle = 0.5 * (close + far)
            within = self._depth_inside_mm(start + middle[:, None] * ways) > 0.0
            far, close = np.where(within, middle, far), np.where(within, close, middle)
        met = start + far[:, None] * ways
        normals = self._normals(met) @ self.cam_from_axle.rotation.T
        return self.cam_from_axle.apply(met), normals

    def _reach(self, eye: FloatArray, sight: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return how far off each line of sight enters the cylinder around the body, and whether.

        Lines that stay beyond its ends do not count.
        """
        flat_eye, flat = eye[[0, 2]], sight[:, [0, 2]]
        a = (flat * flat).sum(axis=1)
        b = flat @ flat_eye
        c = float(flat_eye @ flat_eye) - float(self._radii_mm.max()) ** 2
        square = b * b - a * c
        passes = square > 0.0
        start = (-b - np.sqrt(np.where(passes, square, 0.0))) / a
        ways = (eye[1] + start * sight[:, 1], eye[1] + (start + _INTO_MM[-1]) * sight[:, 1])
        end_mm = self._table_start_mm + (len(self._radii_mm) - 1) * _TABLE_STEP_MM
        between = (np.maximum(*ways) > self._table_start_mm) & (np.minimum(*ways) < end_mm)
        return start, passes & (start > 0.0) & between

    def _depth_inside_mm(self, points_mm: FloatArray) -> FloatArray:
        """Return how deep points of the axle frame, shape (..., 3), lie under the turned profile.

        Negative above it, and beyond its ends.
        """
        place = (points_mm[..., 1] - self._table_start_mm) / _TABLE_STEP_MM
        last = len(self._radii_mm) - 1
        radius = self._radii_mm[np.clip(np.rint(place), 0, last).astype(np.intp)]
        depth = radius - np.hypot(points_mm[..., 0], points_mm[..., 2])
        return np.asarray(np.where((place >= 0.0) & (place <= last), depth, -1.0))

    def _normals(self, points_mm: FloatArray) -> FloatArray:
        """Return outward normals at surface points of the axle frame, shape (N, 3)."""
        slope = np.gradient(self._radii_mm, _TABLE_STEP_MM)
        place = np.rint((points_mm[:, 1] - self._table_start_mm) / _TABLE_STEP_MM).astype(np.intp)
        place = np.clip(place, 0, len(slope) - 1)
        flat = points_mm[:, [0, 2]]
        radius = np.linalg.norm(flat, axis=1)
        # A ray that comes in a millimetre under the rim came in through a face at an end.
        through_end = self._radii_mm[place] - radius > 1.0
        end = np.where(place < len(slope) // 2, -1.0, 1.0)
        lateral = np.where(through_end, end, -slope[place])
        outward = np.where(through_end, 0.0, 1.0 / radius)[:, None] * flat
        normals = np.column_stack([outward[:, 0], lateral, outward[:, 1]])
        return np.asarray(normals / np.linalg.norm(normals, axis=1, keepdims=True))


@dataclass(frozen=True, slots=True, eq=False)
class _SheetLines:
    """The straight lines that a sheet draws in the planes square to the axle.

    In the (x, z) of the axle frame a line is all ``height * across + s * along``, s positive on
    the laser's side.
    """

    across: FloatArray
    along: FloatArray
    steep: float
    lateral: float
    offset_mm: float

    @classmethod
    def of(
        cls, plane: LightPlane, source_in_cam_mm: FloatArray, cam_from_axle: RigidTransform
    ) -> "_SheetLines":
        normal = cam_from_axle.rotation.T @ plane.normal_in_cam
        steep = float(np.hypot(normal[0], normal[2]))
        across = normal[[0, 2]] / steep
        along = np.array([-across[1], across[0]])
        source = cam_from_axle.inverse().apply(source_in_cam_mm[None])[0]
        return cls(
            across=across,
            along=along if source[[0, 2]] @ along > 0.0 else -along,
            steep=steep,
            lateral=float(normal[1]),
            offset_mm=float(plane.distance_mm(cam_from_axle.translation_mm[None])[0]),
        )

    def height_mm(self, y_mm: FloatArray, q_mm: FloatArray) -> FloatArray:
        """Distance from the axle of the line at y and q beside the sheet, shape (S, Q)."""
        return (q_mm[None, :] - self.offset_mm - self.lateral * y_mm[:, None]) / self.steep


def _with_lateral(flat: FloatArray, lateral: FloatArray) -> FloatArray:
    """Put (x, z) of shape (S, Q, 2) and y of shape (S,) together, shape (S, Q, 3)."""
    y = np.broadcast_to(lateral[:, None], flat.shape[:2])
    return np.stack([flat[..., 0], y, flat[..., 1]], axis=-1)
