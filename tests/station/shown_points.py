"""Showings of a rigid target as points.csv, drawn from the geometry without a picture."""

import numpy as np
from rig_recordings import TRUTH

from calib import Target
from station.scenes import Light, RigidTarget, rig_showings
from station.scenes.crossing import crossing_on_board

BOARD = Target.parse("dots:7x8:12")
DOT_PX, STRIPE_PX = 0.05, 0.1
_STRIPE_POINTS = 60


def write_showings(folder, rng, count, *, missing=(), turned_by_hand=()):
    """Write points.csv of each sensor; return the files.

    Parameters
    ----------
    missing
        (sensor, place) of pictures that were not taken.
    turned_by_hand
        Places at which the target moved between the two pictures.
    """
    sensors = TRUTH.sensors
    body = RigidTarget.board_each(rng, sensors, BOARD)
    showings = rig_showings(rng, sensors, body, [Light.GOOD] * count)
    files = {}
    for which, placed in enumerate(sensors):
        lines = ["image,kind,row,col,u,v,sigma_u,sigma_v"]
        for place, showing in enumerate(showings):
            if (placed.name, place) in missing:
                continue
            pose = showing.scenes[placed.name].cam_from_board
            if place in turned_by_hand and which:
                pose = showings[place - 1].scenes[placed.name].cam_from_board
            lines += _rows(f"pose{place}.png", placed.sensor, pose, rng)
        files[placed.name] = folder / f"{placed.name}.csv"
        files[placed.name].write_text("\n".join(lines) + "\n")
    return files


def _rows(name, sensor, pose, rng):
    dots = sensor.camera.project(pose.apply(BOARD.points_mm))
    dots += rng.normal(0.0, DOT_PX, dots.shape)
    for number, (u, v) in enumerate(dots):
        row, col = divmod(number, BOARD.cols)
        yield f"{name},dot,{row},{col},{u:.6f},{v:.6f},{DOT_PX},{DOT_PX}"
    middle = BOARD.points_mm[:, :2].mean(axis=0)
    line = crossing_on_board(sensor.plane, pose, middle)
    along = np.linspace(-35.0, 35.0, _STRIPE_POINTS)[:, None]
    on_board = line.nearest_mm + along * line.direction
    stripe = sensor.camera.project(pose.apply(np.column_stack([on_board, 0.0 * along])))
    # A stripe that lies across the picture is seen sharply in v, and not at all along itself.
    stripe[:, 1] += rng.normal(0.0, STRIPE_PX, len(stripe))
    for u, v in stripe:
        yield f"{name},stripe,,,{u:.6f},{v:.6f},0,{STRIPE_PX}"
