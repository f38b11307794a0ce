"""A store with a calibrated sensor, and sessions of its target, as points in place of pictures."""

from dataclasses import dataclass, field
from datetime import timedelta

import numpy as np
from sensor_points import SIZE_PX, TARGET, write_points
from worker_double import SlowMathematics

from station.operations import add_recalibration, utc_now
from station.pipeline import calibrate_sources
from station.scenes import paper_sensor
from station.settings import RecalibrationSettings
from station.store import (
    STATION,
    Calibration,
    CalibrationPoints,
    CalibrationSession,
    CalibrationState,
    Pass,
    PassState,
    Recalibration,
    Recording,
    SessionState,
    activate,
    the,
)
from station.worker.context import WorkContext
from station.worker.recalibrating import recalibrate

POSES = 12


class PointsMathematics(SlowMathematics):
    """Solves from points.csv at a recording's place; measures as the plain one does."""

    def calibrate(self, sources, target, *, camera=None, **options):
        options = {name: options[name] for name in ("sensor", "method", "progress")}
        self._note(f"begin calibrate {options['sensor']}")
        self._work(options["progress"])
        size = None if camera is not None else SIZE_PX
        found = calibrate_sources(sources, target, camera=camera, size_px=size, **options)
        self._note(f"end calibrate {options['sensor']}")
        return found


@dataclass
class Shop:
    """Lets days go by at a sensor."""

    ground: object
    trace: object
    rng: np.random.Generator
    settings: RecalibrationSettings = field(default_factory=RecalibrationSettings)
    sensor: object = field(default_factory=paper_sensor)
    now: object = field(default_factory=utc_now)
    count: int = 0

    @property
    def store(self):
        return self.ground.store

    @property
    def station_settings(self):
        return self.ground.settings.model_copy(update={"recalibration": self.settings})

    @property
    def context(self):
        mathematics = PointsMathematics(self.trace, step_s=0.0).parts
        layout = self.ground.layout
        return WorkContext(
            self.station_settings, self.store, layout, mathematics, now=lambda: self.now
        )

    def session(self, *, sensor=None, poses=POSES, name=None, target=str(TARGET)):
        """Record a calibration session; return its recording."""
        self.count += 1
        name = name or f"s{self.count}"
        path = self.ground.layout.root / f"{name}.csv"
        write_points(path, sensor or self.sensor, self.rng, count=poses)
        with self.store.change() as session:
            session.add(
                CalibrationSession(
                    id=name, state=SessionState.RECORDED, sensor="left", target=target,
                    pictures=poses, opened_at=self.now,
                )
            )  # fmt: skip
            session.flush()
            recording = f"session.{name}.left"
            session.add(
                Recording(
                    id=recording, sensor="left", session_id=name, path=path.name,
                    opened_at=self.now, closed_at=self.now, recorded=poses,
                )
            )  # fmt: skip
        self.now += timedelta(minutes=1)
        return recording

    def activate_first(self, *, poses=25):
        """Calibrate the sensor with care and bring that into force."""
        recording = self.session(poses=poses)
        path = self.ground.layout.root / f"s{self.count}.csv"
        found = calibrate_sources([path], TARGET, sensor="left", size_px=SIZE_PX)
        with self.store.change() as session:
            row = Calibration(
                id="first", state=CalibrationState.READY, sensor="left", target=str(TARGET),
                method="joint", recording_ids={"recordings": [recording], "laser_off": []},
                created_at=self.now, job_id="job-first", passed=True,
                document=found.document.model_dump_json(),
            )  # fmt: skip
            session.add(row)
            session.flush()
            session.add(CalibrationPoints(calibration_id="first", csv=found.points_csv))
            activate(session, row, sensor="left", seen=None, by=STATION, at=self.now)
        self.now += timedelta(hours=1)

    def order(self, name="r1"):
        """Order a recalibration; return its job."""
        with self.store.change() as session:
            _, job = add_recalibration(session, name, sensor="left", by=STATION, at=self.now)
        return job.id

    def recalibrate(self, name="r1"):
        """Recalibrate the sensor here and now; return what came of it."""
        recalibrate(self.context, self.order(name), sleep=lambda _: None)
        self.now += timedelta(hours=12)
        return self.found(name)

    def found(self, name="r1"):
        with self.store.look() as session:
            return the(session, Recalibration, name)

    def passed(self, name, calibration="first"):
        """Record a pass under a calibration."""
        with self.store.change() as session:
            session.add(Pass(id=name, state=PassState.DONE, opened_at=self.now))
            session.add(
                Recording(
                    id=f"pass.{name}.left", sensor="left", pass_id=name, path=f"{name}.mcap",
                    opened_at=self.now, closed_at=self.now, calibration_id=calibration, recorded=4,
                )
            )  # fmt: skip
        self.now += timedelta(minutes=1)
