"""Stripes on wheels by plain geometry: a solid of revolution cut by a plane and projected."""

from dataclasses import dataclass, field

import numpy as np
from scipy.ndimage import gaussian_filter1d

from calib import (
    CameraModel,
    Cause,
    LaserSensor,
    LightPlane,
    RigidTransform,
    StripePoints,
    kernel_of,
)
from measure import Mounting, reference_profile

RADIUS_MM = 420.0
WIDTH_PX = 1.2
AXLE_AT_REST_MM = np.array([0.0, 0.0, RADIUS_MM])
_PARAMETERS = (2315.0, 2312.0, 1004.0, 555.0, -0.1267, 0.1204, 0.0, 0.0, 0.0)


def trackside(
    *, below_deg=30.0, triangulation_deg=35.0, inwards_deg=14.5, yaw_deg=0.0, distance_mm=490.0
):
    """A sensor between the rails: (exact LaserSensor, rig_from_camera).

    The sheet holds the axle of a wheel at x = 0 (but for the yaw), runs outward below the
    horizon, and the camera looks at it at the triangulation angle, from a little inwards.
    """
    below, yaw, inwards = np.radians([below_deg, yaw_deg, inwards_deg])
    outward = np.array([np.cos(below), 0.0, -np.sin(below)])
    turn = RigidTransform.from_rotation_vector(outward * yaw, np.zeros(3)).rotation
    axial = turn @ [0.0, 1.0, 0.0]
    normal = np.cross(axial, outward)
    aim = AXLE_AT_REST_MM + RADIUS_MM * outward + np.array([0.0, -15.0, 0.0])
    within = np.cos(inwards) * outward - np.sin(inwards) * axial
    angle = np.radians(triangulation_deg)
    to_camera = np.cos(angle) * within + np.sin(angle) * normal
    forward = -to_camera
    right = np.cross(np.cross(forward, axial), forward)
    right /= np.linalg.norm(right)
    rotation = np.column_stack([right, np.cross(forward, right), forward])
    rig_from_camera = RigidTransform(rotation, aim + distance_mm * to_camera)
    normal_in_cam = rotation.T @ normal
    offset = -normal_in_cam @ rig_from_camera.inverse().apply(aim[None])[0]
    plane = LightPlane.from_coefficients([*normal_in_cam, offset])
    camera = CameraModel.from_parameters(np.array(_PARAMETERS), width=2048, height=1088)
    return LaserSensor.exact(camera, plane), rig_from_camera


@dataclass(frozen=True)
class Wheel:
    """A wheel as it stands: profile (y, z), tread radius, place and direction of its axle."""

    reference: str = "S1002"
    tread_wear_mm: float = 0.0
    flange_wear_mm: float = 0.0
    radius_mm: float = RADIUS_MM
    axle_x_mm: float = 0.0
    lateral_mm: float = 0.0
    axle_direction: tuple[float, float] = (0.0, 0.0)  # slopes along x and z
    span_y_mm: tuple[float, float] = (-71.0, 99.0)
    back_face_mm: float = 25.0
    profile: np.ndarray | None = field(default=None, compare=False)

    def points(self, step_mm=0.05):
        """(N, 2): the worn profile, fine."""
        if self.profile is not None:
            return self.profile
        y, z = reference_profile(self.reference).points(step_mm, back_face_mm=self.back_face_mm).T
        return np.column_stack(worn(y, z, self.tread_wear_mm, self.flange_wear_mm))

    def truth(self):
        """Readings by interpolation of the fine profile."""
        y, z = self.points().T
        tip = int(np.argmax(z))
        tread = np.interp(0.0, y[tip:], z[tip:])
        face = slice(tip, int(np.searchsorted(y[tip:], -20.0)) + tip)

        def at(level):
            return float(np.interp(-level, -z[face], y[face]))

        height = z[tip] - tread
        return {
            "flange_height": height,
            "flange_thickness_10": at(tread + 10.0) + 70.0,
            "flange_thickness_12": at(tread + 12.0) + 70.0,
            "flange_gradient_qr": at(tread + 10.0) - at(z[tip] - 2.0),
            "tread_wear": height - reference_profile(self.reference).nominal["flange_height"],
        }


def worn(y, z, tread_wear_mm, flange_wear_mm):
    """Wear grown smoothly: the tread goes down around y = 0, the face moves inwards."""
    rise = 0.5 * (1.0 + np.tanh((y + 28.0) / 7.0))
    tread = tread_wear_mm * rise * np.exp(-0.5 * ((y - 0.0) / 45.0) ** 2)
    face = flange_wear_mm * np.exp(-0.5 * ((z - 11.0) / 5.0) ** 4) * (y > -55.0) * (y < -25.0)
    return y - face, z - tread


def stripe_on(
    wheel, sensor, rig_from_camera, rng=None, *, sigma_px=0.05, spacing_px=1.0, shadows=False
):
    """The stripe of a wheel, about one point per pixel, with noise across it."""
    profile = wheel.points()
    keep = (profile[:, 0] > wheel.span_y_mm[0]) & (profile[:, 0] < wheel.span_y_mm[1])
    points, normals = section_in_rig(wheel, profile[keep], sensor, rig_from_camera)
    camera_from_rig = rig_from_camera.inverse()
    in_cam = camera_from_rig.apply(points)
    facing = np.sum((normals @ camera_from_rig.rotation.T) * -in_cam, axis=1) > 0.0
    if shadows:
        facing &= ~hidden(profile[keep], points, normals, rig_from_camera.translation_mm)
    pixels = sensor.camera.project(in_cam)
    inside = facing & (pixels > 0).all(axis=1) & (pixels < [2047, 1087]).all(axis=1)
    return points_along(pixels, inside, rng, sigma_px, spacing_px)


def section_in_rig(wheel, profile, sensor, rig_from_camera):
    """Where the sheet meets each parallel circle of the wheel, and the surface's normal there."""
    axis = np.array([wheel.axle_direction[0], 1.0, wheel.axle_direction[1]])
    axis /= np.linalg.norm(axis)
    first = np.array([1.0, 0.0, 0.0]) - axis[0] * axis
    first /= np.linalg.norm(first)
    second = np.cross(first, axis)
    tread_z = np.interp(0.0, *profile[np.argmax(profile[:, 1]) :].T)
    height = wheel.radius_mm + tread_z
    centre = np.array([wheel.axle_x_mm, wheel.lateral_mm, height])
    rho = wheel.radius_mm + profile[:, 1]
    foot = centre + profile[:, :1] * axis
    normal = rig_from_camera.rotation @ sensor.plane.normal_in_cam
    on_sheet = rig_from_camera.apply(sensor.plane.intersect(np.array([[0.0, 0.0, 1.0]])))[0]
    c, s = normal @ first, normal @ second
    reach = (normal @ on_sheet - foot @ normal) / (rho * np.hypot(c, s))
    angles = np.arctan2(s, c) + np.arccos(np.clip(reach, -1.0, 1.0)) * np.array([[1.0], [-1.0]])
    circles = [np.cos(a)[:, None] * first + np.sin(a)[:, None] * second for a in angles]
    gaps = [np.linalg.norm(foot + rho[:, None] * u - on_sheet, axis=1).mean() for u in circles]
    outward = circles[int(np.argmin(gaps))]
    tangent = np.gradient(profile, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    normals = -tangent[:, 1:] * axis + tangent[:, :1] * outward
    return foot + rho[:, None] * outward, normals


def hidden(profile, points, normals, eye):
    """Which points of a section the profile hides from an eye that is nearly in its plane."""
    axial = np.array([0.0, 1.0, 0.0])
    outward = normals - (normals @ axial)[:, None] * axial
    outward = outward[np.argmax(np.linalg.norm(outward, axis=1))]
    sight = eye - points
    rise = sight @ (outward / np.linalg.norm(outward)) / np.maximum(np.abs(sight @ axial), 1e-9)
    way = np.sign(sight @ axial)
    y, z = profile.T
    blocked = np.zeros(len(y), dtype=bool)
    for other in range(0, len(y), 4):
        beside = (y[other] - y) * way
        blocked |= (beside > 0.5) & (z[other] - z > rise * beside + 0.02)
    return blocked


def points_along(pixels, inside, rng, sigma_px, spacing_px):
    steps = np.linalg.norm(np.diff(pixels, axis=0), axis=1)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    chosen = np.unique(np.searchsorted(length, np.arange(0.0, length[-1], spacing_px)))
    tangent = np.gradient(pixels, axis=0)[chosen]
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    normal = tangent[:, ::-1] * [1.0, -1.0]
    # Blur draws a stripe to the inside of its bends, by curvature times variance / 2: that of the
    # stripe, alike in all directions here, and that of the detector's kernel.
    variance = WIDTH_PX**2 + kernel_of(np.array([WIDTH_PX]))[0] ** 2
    curvature = curvature_towards_normal(pixels, length)[chosen]
    centre = pixels[chosen] + normal * curvature[:, None] * variance / 2.0
    if rng is not None:
        centre += normal * rng.normal(0.0, sigma_px, (len(centre), 1))
    visible = inside[chosen]
    return make_stripe(centre[visible], normal[visible], sigma_px)


def curvature_towards_normal(pixels, length):
    """Of a fine, exact curve; smoothed over a pixel either side, as the blur itself would."""
    even = np.arange(0.0, length[-1], 0.25)
    u, v = (np.interp(even, length, column) for column in pixels.T)
    smooth = [gaussian_filter1d(c, 1.5 / 0.25, mode="nearest") for c in (u, v)]
    du, dv = (np.gradient(c, 0.25) for c in smooth)
    ddu, ddv = np.gradient(du, 0.25), np.gradient(dv, 0.25)
    bend = (ddu * dv - ddv * du) / np.hypot(du, dv) ** 3
    return np.interp(length, even, bend)


def make_stripe(centre, normal, sigma_px=0.05):
    count = len(centre)
    return StripePoints(
        centre_px=centre.reshape(-1, 2),
        normal=normal.reshape(-1, 2),
        sigma_px=np.full(count, sigma_px),
        width_px=np.full(count, WIDTH_PX),
        peak=np.full(count, 150.0),
        saturated=np.zeros(count, dtype=bool),
        cause=(Cause.NONE,) * count,
    )


def mounting_of(rig_from_camera, **changes):
    return Mounting(rig_from_camera, wheel_radius_mm=RADIUS_MM, **changes)


def mirrored(sensor, rig_from_camera):
    """The sensor and its place seen in a mirror along the rail: (LaserSensor, rig_from_camera)."""
    flip = np.diag([-1.0, 1.0, 1.0])
    rotation = flip @ rig_from_camera.rotation @ flip
    place = flip @ rig_from_camera.translation_mm
    a, b, c, d = sensor.plane.coefficients
    plane = LightPlane.from_coefficients([-a, b, c, d])
    return LaserSensor.exact(sensor.camera, plane), RigidTransform(rotation, place)
