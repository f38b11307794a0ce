"""A store as years of passes fill it: trains of the same wheelsets, again and again."""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any

import numpy as np
from sqlalchemy import insert
from sqlalchemy.orm import Session

from measure import Alarm, Placing, Quantity, Side, Status
from station.progress import Progress
from station.store import (
    AxleWheel,
    Calibration,
    CalibrationState,
    Measurement,
    MeasurementProfile,
    Pass,
    PassState,
    Recording,
    Store,
)

_BEGAN = datetime(2020, 1, 1, tzinfo=UTC)
_BETWEEN_PASSES = timedelta(minutes=20)
_TOGETHER = 50
"""Passes in a transaction: a disk takes its time over each."""
_PROFILE_POINTS = 16
"""Hundreds in truth; what lists and trends do not read may be short, and is soon written."""

Rows = list[dict[str, Any]]


@dataclass(frozen=True, slots=True)
class Traffic:
    """What went by.

    Attributes
    ----------
    passes
        How many trains, all alike.
    axles
        Wheelsets of a train: each gives two measurements.
    trains
        How many different trains take turns.
    """

    passes: int
    axles: int = 200
    trains: int = 5

    @property
    def measurements(self) -> int:
        """How many wheels were measured in all."""
        return self.passes * self.axles * len(Side)

    def wheelset(self, of_pass: int, axle: int) -> str:
        """Return the name of the wheelset at a place of a pass, both from 0."""
        return f"ws-{of_pass % self.trains}-{axle:03}"


def fill(store: Store, traffic: Traffic, progress: Progress, *, seed: int = 20240501) -> None:
    """Put the measurements of all passes into an empty store."""
    rng = np.random.default_rng(seed)
    with store.change() as session:
        session.execute(insert(Calibration), [_calibration(side) for side in Side])
    for first in range(0, traffic.passes, _TOGETHER):
        progress(first / traffic.passes, f"filling, {first * traffic.axles * 2} measurements")
        with store.change() as session:
            for number in range(first, min(first + _TOGETHER, traffic.passes)):
                _fill_pass(session, traffic, number, rng)


def _calibration(side: Side) -> dict[str, Any]:
    return {
        "id": f"of-{side}",
        "state": CalibrationState.READY,
        "sensor": side.value,
        "target": "dots:7x8:12",
        "method": "joint",
        "recording_ids": {"recordings": [], "laser_off": []},
        "created_at": _BEGAN,
        "job_id": "-",
    }


def _fill_pass(session: Session, traffic: Traffic, number: int, rng: np.random.Generator) -> None:
    at, name = _BEGAN + number * _BETWEEN_PASSES, f"p{number:06}"
    session.execute(
        insert(Pass),
        [{"id": name, "state": PassState.DONE, "opened_at": at, "axles": traffic.axles}],
    )
    session.execute(insert(Recording), [_recording(name, side, at) for side in Side])
    first = 1 + number * traffic.axles * len(Side)
    wheels = list(_wheels(traffic, rng))
    common = {"pass_id": name, "reference": "S1002", "software": "bench", "measured_at": at}
    measurements: Rows = []
    axles: Rows = []
    for place, (axle, side, wheel) in enumerate(wheels):
        key = first + place
        measurements.append({
            "id": key,
            "recording_id": f"{name}.{side}",
            "frame": axle,
            "calibration_id": f"of-{side}",
            "sensor": side.value,
            "wheel": wheel,
            **common,
        })
        axles.append(_axle(name, axle, side, traffic.wheelset(number, axle), key))
    session.execute(insert(Measurement), measurements)
    profile = _profile(rng)
    session.execute(
        insert(MeasurementProfile),
        [{"measurement_id": row["id"], "profile": profile} for row in measurements],
    )
    session.execute(insert(AxleWheel), axles)


def _recording(of_pass: str, side: Side, at: datetime) -> dict[str, Any]:
    return {
        "id": f"{of_pass}.{side}",
        "sensor": side.value,
        "pass_id": of_pass,
        "path": f"recordings/passes/{of_pass}/{side}.mcap",
        "opened_at": at,
        "closed_at": at,
        "calibration_id": f"of-{side}",
        "recovered": False,
    }


def _axle(of_pass: str, axle: int, side: Side, wheelset: str, key: int) -> dict[str, Any]:
    return {
        "pass_id": of_pass,
        "place": axle + 1,
        "side": side,
        "number": axle + 1,
        "placing": Placing.CERTAIN,
        "measurement_id": key,
        "others": {"measurements": []},
        "wheelset": wheelset,
        "wheelset_side": side,
        "jumps": {},
    }


def _wheels(
    traffic: Traffic, rng: np.random.Generator
) -> Iterator[tuple[int, Side, dict[str, Any]]]:
    """Yield axle, side, and the wheel's row as a measuring leaves it, its profile taken out."""
    values = 30.0 + rng.normal(0.0, 0.02, (traffic.axles, len(Side), len(Quantity)))
    for axle in range(traffic.axles):
        for place, side in enumerate(Side):
            readings = zip(Quantity, values[axle, place].tolist(), strict=True)
            yield axle, side, _wheel(axle, side, dict(readings))


def _wheel(axle: int, side: Side, values: dict[Quantity, float]) -> dict[str, Any]:
    readings = {
        quantity.value: {
            "value": value,
            "u95": 0.05,
            "status": Status.OK.value,
            "alarm": Alarm.NONE.value,
        }
        for quantity, value in values.items()
    }
    return {
        "source": f"{side}.mcap",
        "sensor": side.value,
        "frame": axle,
        "frames": [axle],
        "time": "2026-07-01T12:00:00Z",
        **readings,
        "quality": {
            "points": 900,
            "left_out": {"steep": 12, "dim": 40, "rail": 30},
            "coverage": 0.98,
            "speckle_share": 0.1,
            "frames_used": [axle],
            "axle_offset_mm": 1.25,
            "sheet_yaw_deg": 0.1,
            "wear_max_at_d_mm": 75.5,
            "unmeasured": {},
        },
        "reason": None,
    }


def _profile(rng: np.random.Generator) -> dict[str, list[float]]:
    names = "d_mm", "h_mm", "sigma_mm"
    return {name: rng.normal(0.0, 1.0, _PROFILE_POINTS).tolist() for name in names}
