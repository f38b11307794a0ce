"""A sensor that sees no more than a wheel's stripe, the wheels before it, and its calibration.

Small pictures cost little to send, write and measure: what is looked at is the service around them.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from calib import LaserSensor, Picture
from station.bench.exact_calibration import exact_calibration
from station.documents import CalibrationDocument
from station.operations import DataLayout, utc_now
from station.scenes import WheelScene, WheelTruth, paper_sensor, trackside_mounting
from station.simulated import ArraySource
from station.store import (
    STATION,
    Calibration,
    CalibrationState,
    Store,
    activate,
    migrate,
)

SENSOR = "left"
CALIBRATION_ID = "exact"
_LEFT_PX, _TOP_PX, _WIDTH_PX, _HEIGHT_PX = 632, 384, 768, 288
"""Where the stripe of a wheel is in the pictures of the whole chip."""


def small_sensor() -> LaserSensor:
    """Return the paper's sensor with that part of its chip alone."""
    whole = paper_sensor()
    camera = replace(
        whole.camera,
        cx=whole.camera.cx - _LEFT_PX,
        cy=whole.camera.cy - _TOP_PX,
        width=_WIDTH_PX,
        height=_HEIGHT_PX,
    )
    return LaserSensor.exact(camera, whole.plane)


def render_wheels(count: int) -> list[Picture]:
    """Return a picture of each of so many wheels, worn more and more."""
    sensor, mounting, rng = small_sensor(), trackside_mounting("left"), np.random.default_rng(1)
    return [
        WheelScene(sensor, mounting, WheelTruth(tread_wear_mm=0.5 * wheel), seed=wheel).render(rng)
        for wheel in range(count)
    ]


@dataclass(frozen=True, slots=True)
class KeptPictures:
    """Makes the frame source of a simulated camera from a file, in the process that serves it."""

    path: Path

    @classmethod
    def keep(cls, pictures: list[Picture], path: Path) -> "KeptPictures":
        """Put pictures into a file."""
        np.save(path, np.stack(pictures))
        return cls(path)

    def __call__(self) -> ArraySource:
        return ArraySource(list(np.load(self.path, mmap_mode="r")))


def true_calibration() -> CalibrationDocument:
    """Return the small sensor and its survey as a calibration that has no doubt."""
    return exact_calibration(SENSOR, small_sensor())


def bring_calibration_into_force(layout: DataLayout) -> None:
    """Have a station, before its first start, measure with the exact calibration."""
    layout.ensure()
    migrate(layout.store_url)
    store = Store.open(layout.store_url)
    try:
        with store.change() as session:
            row = Calibration(
                id=CALIBRATION_ID,
                state=CalibrationState.READY,
                sensor=SENSOR,
                target="dots:7x8:12",
                method="joint",
                recording_ids={"recordings": [], "laser_off": []},
                created_at=utc_now(),
                job_id=f"job-{CALIBRATION_ID}",
                document=true_calibration().model_dump_json(),
                passed=True,
            )
            session.add(row)
            session.flush()
            activate(session, row, sensor=SENSOR, seen=None, by=STATION, at=utc_now())
    finally:
        store.close()
