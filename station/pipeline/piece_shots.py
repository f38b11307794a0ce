"""Stripes on a reference piece as the sensors of a rig saw it, placing by placing."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from calib import LaserSensor, StripePoints
from station.pipeline.piece_stripes import stripes_of
from station.pipeline.rig_sources import sources_by_sensor
from station.pipeline.showings import missing_in, showings_of
from station.progress import Progress

PieceShots = list[tuple[str, dict[str, StripePoints]]]
"""The name of each placing, and by sensor what it saw of it."""


def piece_shots(
    sources: Sequence[Path],
    sensors: Mapping[str, LaserSensor],
    *,
    laser_off: Sequence[Path],
    progress: Progress,
) -> tuple[PieceShots, dict[str, str]]:
    """Return the stripes of each placing by sensor, and which pictures are missing.

    Raises
    ------
    InputUnusable
        If a source cannot be used, or pictures, laser-off pictures and sensors do not pair.
    RecordingUnreadable
        If a recording is damaged.
    """
    names = list(sensors)
    chosen = sources_by_sensor(sources, names)
    dark = sources_by_sensor(laser_off, names) if laser_off else {}
    seen = {}
    for place, (sensor, source) in enumerate(chosen.items()):

        def report(done: float, what: str, first: int = place, name: str = sensor) -> None:
            progress((first + done) / len(chosen), f"{name}: {what}")

        seen[sensor] = list(
            stripes_of(
                [source],
                sensor,
                sensors[sensor].camera,
                laser_off=[dark[sensor]] if dark else (),
                progress=report,
            )
        )
    showings = showings_of(seen)
    shots = [
        (
            name,
            {
                sensor: pose.seen
                for sensor, pose in showing.items()
                if isinstance(pose.seen, StripePoints)
            },
        )
        for name, showing in showings
    ]
    return shots, missing_in(showings, names)


def depths_mm(
    sensors: Mapping[str, LaserSensor], shots: PieceShots, used: Mapping[str, float]
) -> dict[str, tuple[float, float]]:
    """Return how far before each camera the middle nine tenths of its stripes lay."""
    depths = {}
    for name, sensor in sensors.items():
        seen = [shot[name].centre_px for at, shot in shots if at in used and name in shot]
        depth = sensor.locate(np.concatenate(seen))[:, 2]
        near, far = np.nanpercentile(depth, [5.0, 95.0])
        depths[name] = (float(near), float(far))
    return depths
