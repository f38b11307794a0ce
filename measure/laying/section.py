"""From the sheet to a section of the wheel: axial place a and distance r from the axle, mm."""

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from calib import (
    FloatArray,
    IntArray,
    LaserSensor,
    LightPlane,
    RigidTransform,
    RigSensor,
    StripePoints,
    frozen,
)
from measure.laying.bend import bend_px
from measure.mounting import Survey


class SectionMap(Protocol):
    """What takes points on the sheet, camera frame, to (a, r)."""

    def section(self, points_in_cam_mm: FloatArray) -> FloatArray:
        """Map points, shape (N, 3), to (a, r), shape (N, 2)."""

    def jacobian(self, points_in_cam_mm: FloatArray) -> FloatArray:
        """Return the derivative of (a, r) by the point, shape (N, 2, 3)."""


@dataclass(frozen=True, slots=True, eq=False)
class AxleMap:
    """Exact section by a known axle: parallel to rig y, through (x, z).

    An oblique cut is mapped, never scaled: each point has its own distance from the axle.
    """

    rig_from_camera: RigidTransform
    axle_x_mm: float
    axle_z_mm: float

    def section(self, points_in_cam_mm: FloatArray) -> FloatArray:
        """Map points, shape (N, 3), to (a, r), shape (N, 2)."""
        x, y, z = self.rig_from_camera.apply(points_in_cam_mm).T
        return np.column_stack([y, np.hypot(x - self.axle_x_mm, z - self.axle_z_mm)])

    def jacobian(self, points_in_cam_mm: FloatArray) -> FloatArray:
        """Return the derivative of (a, r) by the point, shape (N, 2, 3)."""
        outward = self.outward_in_rig(points_in_cam_mm)
        along = np.broadcast_to([0.0, 1.0, 0.0], outward.shape)
        return np.stack([along, outward], axis=1) @ self.rig_from_camera.rotation

    def outward_in_rig(self, points_in_cam_mm: FloatArray) -> FloatArray:
        """Return unit vectors from the axle to the points, shape (N, 3)."""
        x, _, z = self.rig_from_camera.apply(points_in_cam_mm).T
        across = np.column_stack([x - self.axle_x_mm, np.zeros(len(x)), z - self.axle_z_mm])
        return np.asarray(across / np.linalg.norm(across, axis=1)[:, None])


@dataclass(frozen=True, slots=True, eq=False)
class SheetMap:
    """Section taken for radial: the sheet's own plane, turned so that a is axial and r outward.

    Attributes
    ----------
    axes_in_cam
        Shape (2, 3), unit, at right angles, in the sheet: directions of a and of r.
    """

    axes_in_cam: FloatArray

    def __post_init__(self) -> None:
        object.__setattr__(self, "axes_in_cam", frozen(self.axes_in_cam, (2, 3), "axes_in_cam"))

    @classmethod
    def in_plane(cls, plane: LightPlane, angle_rad: float, *, mirrored: bool) -> "SheetMap":
        """Make the map whose r is turned by an angle from the direction to the camera."""
        normal = plane.normal_in_cam
        to_camera = np.array([0.0, 0.0, -1.0])
        up = to_camera - (to_camera @ normal) * normal
        up /= np.linalg.norm(up)
        right = np.cross(up, normal)
        cos, sin = np.cos(angle_rad), np.sin(angle_rad)
        along = cos * right - sin * up
        return cls(np.stack([-along if mirrored else along, cos * up + sin * right]))

    def section(self, points_in_cam_mm: FloatArray) -> FloatArray:
        """Map points, shape (N, 3), to (a, r), shape (N, 2)."""
        return np.asarray(points_in_cam_mm @ self.axes_in_cam.T)

    def jacobian(self, points_in_cam_mm: FloatArray) -> FloatArray:
        """Return the derivative of (a, r) by the point, shape (N, 2, 3)."""
        return np.broadcast_to(self.axes_in_cam, (len(points_in_cam_mm), 2, 3))


@dataclass(frozen=True, slots=True, eq=False)
class SheetPoints:
    """The stripe's points in space, and what moves them.

    Attributes
    ----------
    stripe
        The points of the picture they belong to.
    points_in_cam_mm
        Shape (N, 3).
    across_mm, along_mm
        Shape (N, 3): motion of the point for one sigma across the stripe, and for one pixel
        along it.
    bend_mm
        Shape (N, 3): how far the bend of the stripe had drawn the point, where that is taken off.
    by_sensor
        Shape (N, 3, 13): motion of the point by the sensor's parameters.
    """

    stripe: StripePoints
    points_in_cam_mm: FloatArray
    across_mm: FloatArray
    along_mm: FloatArray
    bend_mm: FloatArray
    by_sensor: FloatArray

    def __len__(self) -> int:
        return len(self.stripe)

    @classmethod
    def of(cls, stripe: StripePoints, sensor: LaserSensor) -> "SheetPoints":
        """Locate the points of a stripe; pixels whose ray misses the sheet are left out."""
        return cls._located(stripe, np.zeros(len(stripe)), sensor)

    def unbent(self, sensor: LaserSensor) -> "SheetPoints":
        """Locate the points again, with what their bends had drawn them taken off.

        How far that was is told from the widths of all points: only points of the wheel may be
        among them.
        """
        drawn_px = bend_px(self.stripe)
        centre_px = self.stripe.centre_px - drawn_px[:, None] * self.stripe.normal
        return self._located(replace(self.stripe, centre_px=centre_px), drawn_px, sensor)

    @classmethod
    def _located(
        cls, stripe: StripePoints, drawn_px: FloatArray, sensor: LaserSensor
    ) -> "SheetPoints":
        points, by_pixel, by_sensor = sensor.locate_with_jacobians(stripe.centre_px)
        hit = np.isfinite(points).all(axis=1)
        seen = stripe
        if not hit.all():
            seen = stripe.select(np.flatnonzero(hit))
            points, by_pixel, by_sensor = points[hit], by_pixel[hit], by_sensor[hit]
        tangent = seen.normal[:, ::-1] * [-1.0, 1.0]
        across = (by_pixel @ seen.normal[:, :, None])[:, :, 0]
        return cls(
            stripe=seen,
            points_in_cam_mm=points,
            across_mm=across * seen.sigma_px[:, None],
            along_mm=(by_pixel @ tangent[:, :, None])[:, :, 0],
            bend_mm=across * drawn_px[hit, None],
            by_sensor=by_sensor,
        )

    def select(self, keep: IntArray) -> "SheetPoints":
        """Return the points that an index array picks."""
        return SheetPoints(
            self.stripe.select(keep),
            self.points_in_cam_mm[keep],
            self.across_mm[keep],
            self.along_mm[keep],
            self.bend_mm[keep],
            self.by_sensor[keep],
        )


@dataclass(frozen=True, slots=True, eq=False)
class Section:
    """Points of a section, (a, r), with what moves them there.

    Attributes
    ----------
    points_mm
        Shape (N, 2).
    own_mm
        Shape (N, 2): motion for one sigma across the stripe.
    tangent
        Shape (N, 2), unit, along the stripe.
    to_camera
        Shape (N, 2): towards the camera, as far as the section's plane shows it.
    sigma_mm
        Shape (N,): standard deviation across the profile.
    jacobian
        Shape (N, 2, 3): (a, r) by the point in the camera frame.
    """

    points_mm: FloatArray
    own_mm: FloatArray
    tangent: FloatArray
    to_camera: FloatArray
    sigma_mm: FloatArray
    jacobian: FloatArray

    @classmethod
    def of(cls, sheet: SheetPoints, section_map: SectionMap) -> "Section":
        """Map points of the sheet to the section."""
        jacobian = section_map.jacobian(sheet.points_in_cam_mm)
        own, along, to_camera = (
            np.einsum("nij,nj->ni", jacobian, motion)
            for motion in (sheet.across_mm, sheet.along_mm, -sheet.points_in_cam_mm)
        )
        tangent = along / np.linalg.norm(along, axis=1)[:, None]
        sigma = np.abs(tangent[:, 0] * own[:, 1] - tangent[:, 1] * own[:, 0])
        points = section_map.section(sheet.points_in_cam_mm)
        return cls(points, own, tangent, to_camera, np.maximum(sigma, 1e-6), jacobian)

    def select(self, index: IntArray) -> "Section":
        """Return the points that an index array picks."""
        return Section(
            self.points_mm[index],
            self.own_mm[index],
            self.tangent[index],
            self.to_camera[index],
            self.sigma_mm[index],
            self.jacobian[index],
        )


def radial_place_mm(sensor: RigSensor, survey: Survey, points_in_cam_mm: FloatArray) -> float:
    """Return the rig x where an axle of nominal radius would lie in the sheet, beside the points.

    Where the sheet runs level and holds no such place, it is the x of the points themselves.
    """
    rig = sensor.rig_from_camera
    normal = rig.rotation @ sensor.sensor.plane.normal_in_cam
    middle = np.median(rig.apply(points_in_cam_mm), axis=0)
    if abs(normal[0]) < 0.05:
        return float(middle[0])
    return float(middle[0] - normal[2] / normal[0] * (survey.wheel_radius_mm - middle[2]))
