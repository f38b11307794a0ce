"""Two sensors before one wheel by plain geometry: an inner and an outer one, sheets apart."""

import numpy as np
import wheel_stripes as ws

from calib import RIG_PARAMETERS, LaserSensor, LightPlane, Rig, RigSensor, moved_by
from measure import Shot, Survey, WheelFrame

STANDS = {
    "inner": ws.trackside(below_deg=45.0, inwards_deg=45.0),
    "outer": ws.trackside(below_deg=30.0, inwards_deg=-28.0),
}
SURVEY = Survey(wheel_radius_mm=ws.RADIUS_MM)
SIZE = len(RIG_PARAMETERS)


def rig(covariance=None):
    """Both sensors where they truly stand."""
    sensors = tuple(RigSensor(name, sensor, pose) for name, (sensor, pose) in STANDS.items())
    empty = np.zeros((2 * SIZE, 2 * SIZE))
    return Rig(sensors, empty if covariance is None else covariance)


def poses_covariance(turn_rad=5e-5, shift_mm=0.02):
    """What a rig calibration leaves of the outer sensor's place beside the inner's."""
    covariance = np.zeros((2 * SIZE, 2 * SIZE))
    at = np.arange(SIZE + 13, 2 * SIZE)
    covariance[at, at] = np.repeat([turn_rad**2, shift_mm**2], 3)
    return covariance


def drawn_rig(rng, covariance):
    """The rig as a calibration with that covariance found it."""
    step = rng.multivariate_normal(np.zeros(len(covariance)), covariance)
    sensors = []
    for each, own in zip(rig().sensors, step.reshape(2, SIZE), strict=True):
        plane = LightPlane.from_coefficients(each.sensor.plane.coefficients + own[9:13])
        sensor = LaserSensor(each.sensor.camera, plane, np.zeros((13, 13)))
        sensors.append(RigSensor(each.name, sensor, moved_by(each.rig_from_camera, own[13:])))
    return Rig(tuple(sensors), covariance)


def shot(wheel, rng=None, *, moved=None, names=("inner", "outer"), frame=1, time_ns=0, **noise):
    """What the sensors see at once; `moved` is by how much each has shifted, mm, rig frame."""
    frames = []
    for name in names:
        sensor, pose = STANDS[name]
        shift = np.zeros(3) if moved is None else np.asarray(moved.get(name, np.zeros(3)))
        pose = moved_by(pose, np.concatenate([np.zeros(3), shift]))
        stripe = ws.stripe_on(wheel, sensor, pose, rng, shadows=True, **noise)
        frames.append(WheelFrame(stripe, frame, f"{name}.mcap", time_ns, name))
    return Shot(tuple(frames))
