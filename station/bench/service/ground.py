"""A station as it is after some months: calibrated, with measurements and trains to measure."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from sqlalchemy.orm import Session

from station.bench.exact_calibration import exact_calibration
from station.bench.service.filled_store import Traffic, fill
from station.bench.service.trains_by import RATE_HZ, WheelsGoingBy, record_train, render_wheels
from station.bench.service.trains_waiting import RecordedTrain, TrainsWaiting
from station.operations import DataLayout, utc_now
from station.progress import Progress, silent
from station.store import (
    Activation,
    Calibration,
    CalibrationState,
    JobKind,
    JobState,
    Store,
    add_job,
    migrate,
)
from station.store.callers import Scope, add_key

SENSOR = "left"
_NETWORK = "127.34"
_CALIBRATION = "exact"


@dataclass(frozen=True, slots=True)
class Extent:
    """How much there is.

    Attributes
    ----------
    past
        Trains that were measured long ago.
    wheels
        Of each train that waits to be measured.
    longest_pass_s
        What the disk must have space for.
    """

    past: Traffic
    wheels: int
    longest_pass_s: float


@dataclass(frozen=True, slots=True)
class Ground:
    """What a station is started on.

    Attributes
    ----------
    settings
        Its settings file, but where its data and its port are.
    source
        What its camera sees.
    key
        Opens all calls.
    past_pass
        One that was measured long ago.
    """

    PAST_JOB: ClassVar = "job-past"

    folder: Path
    settings: str
    source: WheelsGoingBy
    address: str
    key: str
    past_pass: str
    train: RecordedTrain

    @classmethod
    def prepared(cls, folder: Path, extent: Extent, progress: Progress = silent) -> "Ground":
        """Make it all in an empty folder."""
        progress(0.0, "rendering wheels")
        pictures = folder / "wheels.npy"
        source = render_wheels(pictures)
        address = f"{_NETWORK}.{os.getpid() % 250 + 2}.1"
        layout = DataLayout(folder / "data")
        layout.ensure()
        migrate(layout.store_url)
        store = Store.open(layout.store_url)
        progress(0.3, "filling the store")
        fill(store, extent.past, silent)
        progress(0.6, "recording a train")
        path = layout.pass_recording("waiting", SENSOR)
        frames = record_train(layout.root / path, pictures, sensor=SENSOR, wheels=extent.wheels)
        train = RecordedTrain(path, frames, SENSOR, _CALIBRATION)
        with store.change() as session:
            key = add_key(session, "bench", [Scope.OPERATE], at=utc_now())
            _calibrate(session)
            past = add_job(session, cls.PAST_JOB, JobKind.MEASURE, "p000000", at=utc_now())
            past.state = JobState.DONE
        store.close()
        settings = _settings_toml(address, extent)
        return cls(folder, settings, source, address, key, "p000000", train)

    def trains_waiting(self) -> TrainsWaiting:
        """Return what has the station measure trains of the past."""
        return TrainsWaiting(DataLayout(self.folder / "data"), self.train)


def _settings_toml(address: str, extent: Extent) -> str:
    mounting = exact_calibration(SENSOR).mounting
    lines = [
        'name = "bench"',
        "[storage]",
        "keep_free_gb = 0.2",
        f"longest_pass_s = {extent.longest_pass_s:g}",
        "[[sensors]]",
        f'id = "{SENSOR}"',
        f'address = "{address}"',
        'trigger = "free"',
        f"frame_rate_hz = {RATE_HZ}",
    ]
    if mounting is not None:
        lines += [
            "[sensors.mounting]",
            f"rotation_vector = {list(mounting.rotation_vector)}",
            f"translation_mm = {list(mounting.translation_mm)}",
        ]
    return "\n".join([*lines, ""])


def _calibrate(session: Session) -> None:
    now = utc_now()
    session.add(
        Calibration(
            id=_CALIBRATION,
            state=CalibrationState.READY,
            sensor=SENSOR,
            target="dots:7x8:12",
            method="joint",
            recording_ids={"recordings": [], "laser_off": []},
            created_at=now,
            job_id="-",
            document=exact_calibration(SENSOR).model_dump_json(),
            passed=True,
        )
    )
    session.flush()
    session.add(
        Activation(
            sensor=SENSOR,
            version=1,
            calibration_id=_CALIBRATION,
            activated_at=now,
            activated_by="bench",
        )
    )
