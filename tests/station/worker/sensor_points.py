"""Points of a chessboard and of the stripe across it, as a sensor of known truth sees them.

Written as points.csv, in place of pictures: what is solved from them is a real calibration.
"""

import csv

import numpy as np

from calib import LaserSensor, LightPlane, RigidTransform, Target
from station.scenes import paper_sensor

TARGET = Target.parse("chessboard:7x8:12")
SIZE_PX = (2048, 1088)
DOTS_PX, STRIPE_PX = 0.01, 0.03
_STRIPE_POINTS = 40
_HEADER = ("image", "kind", "row", "col", "u", "v", "sigma_u", "sigma_v")


def turned(sensor, by_rad):
    """Return the sensor with its sheet turned about the camera's x, by where it meets the axis."""
    plane = sensor.plane
    turn = RigidTransform.from_rotation_vector((by_rad, 0.0, 0.0), (0.0, 0.0, 0.0))
    normal = turn.apply(plane.normal_in_cam[None])[0]
    foot = np.array([0.0, 0.0, -plane.offset_mm / plane.normal_in_cam[2]])
    coefficients = np.append(normal, -normal @ foot)
    return LaserSensor.exact(sensor.camera, LightPlane.from_coefficients(coefficients))


def poses(rng, count, sensor=None):
    """Draw poses of the chessboard that the sheet crosses, all of it in view."""
    sensor = sensor or paper_sensor()
    found = []
    while len(found) < count:
        tilt = rng.uniform(-0.5, 0.5, size=3)
        centre_px = np.array([SIZE_PX]) * rng.uniform(0.35, 0.65, size=2)
        centre = sensor.locate(centre_px)[0]
        turn = RigidTransform.from_rotation_vector(tuple(tilt), (0.0, 0.0, 0.0))
        shift = centre - turn.apply(TARGET.points_mm.mean(axis=0)[None])[0]
        pose = RigidTransform.from_rotation_vector(tuple(tilt), tuple(shift))
        seen = sensor.camera.project(pose.apply(TARGET.points_mm))
        if (seen > 10).all() and (seen < np.array(SIZE_PX) - 10).all():
            found.append(pose)
    return found


def write_points(path, sensor, rng, *, count=10, target_poses=None):
    """Write points.csv of poses drawn at random; return the poses."""
    drawn = target_poses or poses(rng, count, sensor)
    with path.open("w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(_HEADER)
        for index, pose in enumerate(drawn):
            writer.writerows(_rows(f"pose{index}", sensor, pose, rng))
    return drawn


def _rows(name, sensor, pose, rng):
    dots = sensor.camera.project(pose.apply(TARGET.points_mm))
    dots = dots + rng.normal(0.0, DOTS_PX, dots.shape)
    columns = round(TARGET.points_mm[:, 0].max() / TARGET.pitch_mm) + 1
    for place, (u, v) in enumerate(dots):
        row, col = divmod(place, columns)
        yield name, "dot", row, col, f"{u:.6f}", f"{v:.6f}", DOTS_PX, DOTS_PX
    line = sensor.camera.project(_on_sheet(sensor, pose))
    along = line[-1] - line[0]
    normal = np.array([-along[1], along[0]]) / np.linalg.norm(along)
    line = line + rng.normal(0.0, STRIPE_PX, (len(line), 1)) * normal
    for u, v in line:
        sigma_u, sigma_v = np.abs(normal) * STRIPE_PX
        yield name, "stripe", "", "", f"{u:.6f}", f"{v:.6f}", f"{sigma_u:.6f}", f"{sigma_v:.6f}"


def _on_sheet(sensor, pose):
    """Return points of the board that lie in the sheet, one for each place across it."""
    span = TARGET.points_mm[:, :2].max(axis=0)
    across = np.linspace(0.05, 0.95, _STRIPE_POINTS) * span[0]
    ends = [
        pose.apply(np.column_stack([across, np.full_like(across, y), np.zeros_like(across)]))
        for y in (0.0, span[1])
    ]
    away = [end @ sensor.plane.normal_in_cam + sensor.plane.offset_mm for end in ends]
    share = (away[0] / (away[0] - away[1]))[:, None]
    return ends[0] + share * (ends[1] - ends[0])
