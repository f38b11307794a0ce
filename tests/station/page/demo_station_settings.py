"""The settings file of the demo station."""

from collections.abc import Mapping
from pathlib import Path

from demo_station_truth import INNER, RIG, RIGHT, SENSORS, TRACK_MM, Truth

_HEAD = """\
name = "Nordhof"
data_dir = "data"
port = {port}
reference = "S1002"

[limits]
regime = "Nordhof 2026"
tread_wear = {{ high = 6.0, warn_within = 0.8 }}
hollow_depth = {{ high = 4.5 }}
flange_thickness_10 = {{ low = 27.0, high = 33.0, warn_within = 1.0 }}

[storage]
keep_free_gb = 0.1
most_axles = 40
most_poses = 40
longest_pass_s = 20.0
reserve_mb = 20.0

[track]
distance_mm = {track_mm}
sigma_distance_mm = 0.3
fewest_pairs = 1

[recalibration]
at = 02:30:00
zone = "Europe/Berlin"

[recalibration.gates]
oldest_calibration_days = 14.0
longest_unchecked_days = 45.0
"""


def write_settings(
    path: Path, truth: Truth, *, addresses: Mapping[str, str] | None = None, port: int = 0
) -> Path:
    """Write the settings file of the demo station; return it.

    Parameters
    ----------
    addresses
        Of the sensors' cameras; without it, where there are none.
    """
    reached = addresses or {name: f"127.41.0.{n}" for n, name in enumerate(SENSORS, start=1)}
    lines = [_HEAD.format(port=port, track_mm=TRACK_MM)]
    for sensor in SENSORS:
        lines += [
            "[[sensors]]",
            f'id = "{sensor}"',
            f'side = "{"right" if sensor == RIGHT else "left"}"',
            f'address = "{reached[sensor]}"',
            'trigger = "Line1"',
            "",
        ]
        if sensor in {INNER, RIGHT}:  # the rig is placed by its anchor's
            lines += _mounting(truth, sensor)
    names = ", ".join(f'"{name}"' for name in SENSORS if name != RIGHT)
    lines += ["[[rigs]]", f'id = "{RIG}"', f"sensors = [{names}]", ""]
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def _mounting(truth: Truth, sensor: str) -> list[str]:
    pose = truth.mounting(sensor)
    return [
        "[sensors.mounting]",
        f"rotation_vector = {pose.rotation_vector.tolist()}",
        f"translation_mm = {pose.translation_mm.tolist()}",
        "",
    ]
