"""Stripes of two sensors on one prism in space, by plain geometry."""

import numpy as np
from piece_stripes import DOUBTED, SENSOR, SIGMAS, kernelled, points_with_noise

from calib import (
    CameraModel,
    LaserSensor,
    LightPlane,
    Rig,
    RigidTransform,
    RigSensor,
    moved_by,
)
from measure import Piece

MIDDLE_PX = (1000.0, 560.0)
SIGMA_TURN_RAD = 3e-5
SIGMA_SHIFT_MM = 0.01


def rib(**about):
    """A rib with upright walls, of which each sensor sees one, between levels that differ."""
    x = [-40, -13, -13, -4, 4, 13, 13, 45]
    z = [0, 0, 22, 22, 16, 16, 3, 3]
    return Piece.from_corners("rib", "9", [[(a, b)] for a, b in zip(x, z, strict=True)], **about)


def mounted(angle_rad, *, turned_rad=0.0, at_mm=(0.0, 0.0, 0.0)):
    """Return rig_from_camera; the sheet holds rig y, and z where it is not turned about y.

    The camera looks from an angle to z, towards +y; the middle of its picture shows a place.
    """
    middle = SENSOR.locate(np.array([MIDDLE_PX]))[0]
    normal = SENSOR.plane.normal_in_cam
    up = -SENSOR.plane.offset_mm * normal - middle
    up /= np.linalg.norm(up)
    own = np.column_stack([normal, np.cross(up, normal), up])
    to_camera = np.array([0.0, np.sin(angle_rad), np.cos(angle_rad)])
    along = np.array([1.0, 0.0, 0.0])
    there = np.column_stack([along, np.cross(to_camera, along), to_camera])
    turn = RigidTransform.from_rotation_vector([0.0, turned_rad, 0.0], np.zeros(3)).rotation
    rotation = turn @ there @ own.T
    return RigidTransform(rotation, np.array(at_mm) - rotation @ middle)


def rig_of_two(*, turned_rad=0.0, apart_mm=0.0, doubted=True):
    """An inner and an outer sensor, 80 degrees apart in the section; inner carries the frame."""
    poses = {
        "inner": mounted(np.radians(-40.0)),
        "outer": mounted(np.radians(40.0), turned_rad=turned_rad, at_mm=(apart_mm, 0.0, 0.0)),
    }
    sigmas = np.concatenate([SIGMAS, np.zeros(6), SIGMAS, pose_sigmas()])
    covariance = np.diag(sigmas**2) if doubted else np.zeros((38, 38))
    sensor = DOUBTED if doubted else SENSOR
    return Rig(tuple(RigSensor(name, sensor, pose) for name, pose in poses.items()), covariance)


def pose_sigmas():
    return np.repeat([SIGMA_TURN_RAD, SIGMA_SHIFT_MM], 3)


def drawn_rig(rig, rng, scale=1.0):
    """A rig that is off as its covariance, which must be diagonal, says."""
    step = scale * np.sqrt(np.diag(rig.covariance)) * rng.normal(size=len(rig.covariance))
    sensors = []
    for each in rig.sensors:
        own = step[rig.columns(each.name)]
        centre = np.concatenate([each.sensor.camera.parameters, each.sensor.plane.coefficients])
        camera = CameraModel.from_parameters((centre + own[:13])[:9], width=2048, height=1088)
        plane = LightPlane.from_coefficients((centre + own[:13])[9:])
        pose = moved_by(each.rig_from_camera, own[13:])
        sensors.append(RigSensor(each.name, LaserSensor.exact(camera, plane), pose))
    return Rig(tuple(sensors), np.zeros_like(rig.covariance))


def drifted(rig, name, *, about_mm=(0.0, 0.0, 0.0), shift_mm=(0, 0, 0), turn_rad=(0, 0, 0)):
    """The rig with one sensor moved: turned about a place, then shifted."""
    turn = RigidTransform.from_rotation_vector(turn_rad, np.zeros(3)).rotation
    about = np.array(about_mm)
    motion = RigidTransform(turn, about - turn @ about + np.array(shift_mm, dtype=float))
    sensors = tuple(
        RigSensor(
            each.name,
            each.sensor,
            motion @ each.rig_from_camera if each.name == name else each.rig_from_camera,
        )
        for each in rig.sensors
    )
    return Rig(sensors, rig.covariance)


def held(piece, *, at_mm=(0.0, 0.0), turn_rad=0.0, slant_rad=(0.0, 0.0), sheet_turn_rad=0.0):
    """rig_from_piece: x towards rig y, z up, its length along rig x; the middle of its edges at
    (y, z), turned about its length, and slanted about its x and z."""
    upright = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    x, z = piece.corners_mm.mean(axis=0)
    about_x, about_z = slant_rad
    turns = [
        RigidTransform.from_rotation_vector(axis, np.zeros(3)).rotation
        for axis in ([0.0, sheet_turn_rad, 0.0], [about_x, 0.0, about_z], [0.0, turn_rad, 0.0])
    ]
    rotation = turns[0] @ upright @ turns[1] @ turns[2]
    return RigidTransform(rotation, np.array([0.0, *at_mm]) - rotation @ [x, 0.0, z])


def stripe_of(placed, rig_from_piece, piece, rng, *, noise_px=0.05):
    """The stripe that a sensor of a rig sees on a piece; what the piece hides of itself is dark."""
    cam_from_piece = placed.rig_from_camera.inverse() @ rig_from_piece
    profile, outward = piece.samples(0.02)
    plane, sensor = placed.sensor.plane, placed.sensor

    def lit(section_mm):
        """Where the line along the piece through each place of its section meets the sheet."""
        start = cam_from_piece.apply(np.insert(section_mm, 1, 0.0, axis=1))
        along = cam_from_piece.rotation[:, 1]
        far = -plane.distance_mm(start) / (plane.normal_in_cam @ along)
        return start + far[:, None] * along

    camera = cam_from_piece.inverse().translation_mm[[0, 2]]
    sight = camera - profile
    sight /= np.linalg.norm(sight, axis=1)[:, None]
    seen = ((outward * sight).sum(axis=1) > 0.2) & ~_hidden(profile, camera, piece)
    profile, outward = profile[seen], outward[seen]
    centre = sensor.camera.project(lit(profile))
    step = sensor.camera.project(lit(profile + 1e-3 * outward[:, ::-1] * [1.0, -1.0])) - centre
    normal = np.column_stack([-step[:, 1], step[:, 0]])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    length = np.concatenate([[0.0], np.linalg.norm(np.diff(centre, axis=0), axis=1).cumsum()])
    index = np.unique(np.floor(length).astype(int), return_index=True)[1]
    off = noise_px * kernelled(rng, len(index))
    return points_with_noise(centre[index] + off[:, None] * normal[index], normal[index])


def shot_of(rig, rig_from_piece, piece, rng, *, noise_px=0.05, only=None):
    """What all sensors of a rig see of one placing."""
    return {
        each.name: stripe_of(each, rig_from_piece, piece, rng, noise_px=noise_px)
        for each in rig.sensors
        if only is None or each.name in only
    }


def _hidden(points, camera, piece):
    """Tell which points another side hides from the camera."""
    hidden = np.zeros(len(points), dtype=bool)
    sight = camera - points
    for face in piece.faces:
        start, step = face.start_mm, face.end_mm - face.start_mm
        with np.errstate(divide="ignore", invalid="ignore"):
            across = sight[:, 0] * step[1] - sight[:, 1] * step[0]
            off = start - points
            far = (off[:, 0] * step[1] - off[:, 1] * step[0]) / across
            place = (off[:, 0] * sight[:, 1] - off[:, 1] * sight[:, 0]) / across
        hidden |= (far > 1e-3) & (place > 0.0) & (place < 1.0)
    return hidden
