"""A worker process with slow, plain mathematics that leaves a trace of what it did."""

import threading
import time
from collections.abc import Collection
from datetime import UTC, datetime
from pathlib import Path

from calib import TooFewViews
from station.documents import (
    CalibrationDocument,
    MeasurementDocument,
    RigDocument,
    WheelDocument,
)
from station.pipeline import CalibrationOutcome, RigOutcome
from station.serve import log_as
from station.worker.context import Mathematics
from station.worker.process import work

WHEELS = 4
NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)


def a_calibration_document(sensor="left"):
    return CalibrationDocument.model_validate({
        "sensor": sensor,
        "created": NOON,
        "software": "treadline 0",
        "method": "joint",
        "camera": {"fx": 1, "fy": 1, "cx": 0, "cy": 0, "width": 8, "height": 8},
        "plane": {"a": 0, "b": 0, "c": -1, "d": 500},
        "plane_covariance": [[0.0] * 4] * 4,
        "rms": {"dots_px": 0.1, "stripe_px": 0.1},
        "poses": [],
        "quality": {},
        "options": {},
        "inputs": [],
    })


def a_rig_document(rig, sensors):
    size = 19 * len(sensors)
    plain = a_calibration_document()
    return RigDocument.model_validate({
        "rig": rig,
        "side": "left",
        "created": NOON,
        "software": "treadline 0",
        "method": "boards",
        "anchor": sensors[0],
        "sensors": [
            {
                "sensor": name,
                "calibration": a_calibration_document(name).fingerprint,
                "camera": plain.camera,
                "plane": plain.plane,
                "rotation_vector": (0, 0, 0),
                "translation_mm": (0, 0, 0),
            }
            for name in sensors
        ],
        "covariance": [[0.0] * size] * size,
        "survey": {},
        "rms": {"dots_px": 0.1, "stripe_px": 0.1},
        "quality": {},
        "options": {},
        "inputs": [],
    })


class SlowMathematics:
    """Takes `steps` steps of `step_s` for a job, and writes a line at its begin and its end.

    After a line of `stays_at` it stays where it is, until somebody kills the process.
    """

    def __init__(
        self,
        trace: Path,
        *,
        step_s: float = 0.05,
        steps: int = WHEELS,
        stays_at: Collection[str] = (),
    ) -> None:
        self._trace = trace
        self._stays_at = frozenset(stays_at)
        self._step_s = step_s
        self._steps = steps

    def calibrate(self, sources, target, *, sensor, progress, **_rest):
        self._note(f"begin calibrate {sensor}")
        self._work(progress)
        if target.rows == 2:
            raise TooFewViews("1 view; allowed: 3 and more; take more pictures")
        self._note(f"end calibrate {sensor}")
        return CalibrationOutcome(a_calibration_document(sensor), "image,kind\n", ())

    def measure(self, sources, calibration, *, reference, limits, progress, since=None, cores=None):
        (source,) = sources
        self._note(f"begin measure {source.stem}")
        self._work(progress)
        if "unreadable" in source.stem:
            raise RuntimeError("a fault nobody foresaw")
        self._note(f"end measure {source.stem}")
        wheels = [
            WheelDocument(source=source.name, sensor=calibration.sensor, frame=frame)
            for frame in range(1, WHEELS + 1)
        ]
        return MeasurementDocument(
            created=NOON,
            software="treadline 0",
            calibration="0" * 64,
            reference=reference,
            regime=limits.regime,
            wheels=wheels,
        )

    def calibrate_rig(self, sources, order, *, progress):
        self._note(f"begin calibrate rig {order.rig}")
        self._work(progress)
        self._note(f"end calibrate rig {order.rig}")
        names = [each.sensor for each in order.calibrations]
        return RigOutcome(a_rig_document(order.rig, names), dict.fromkeys(names, "image,kind\n"))

    def measure_rig(self, sources, rig, *, silent_sensors, reference, limits, progress, **_rest):
        self._note(f"begin measure rig {rig.rig} {' '.join(sources)}")
        self._work(progress)
        self._note(f"end measure rig {rig.rig}")
        first = next(iter(sources.values()))
        wheels = [
            WheelDocument(
                source=first.name,
                sensor=rig.rig,
                sensors=tuple(sources),
                frame=frame,
                frames=(frame,),
                quality={"by_sensor": dict(silent_sensors)},
            )
            for frame in range(1, WHEELS + 1)
        ]
        return MeasurementDocument(
            created=NOON,
            software="treadline 0",
            calibration=None,
            rigs={rig.rig: rig.fingerprint},
            reference=reference,
            regime=limits.regime,
            wheels=wheels,
        )

    @property
    def parts(self):
        return Mathematics(self.calibrate, self.measure, self.calibrate_rig, self.measure_rig)

    def _work(self, progress):
        for step in range(self._steps):
            progress(step / self._steps, f"step {step}")
            time.sleep(self._step_s)

    def _note(self, line):
        with self._trace.open("a") as stream:
            stream.write(line + "\n")
        if line in self._stays_at:
            threading.Event().wait()


def run_double(settings, trace, step_s, stays_at=()):
    """Be the worker process."""
    log_as("worker")
    mathematics = SlowMathematics(trace, step_s=step_s, stays_at=stays_at)
    stop = threading.Event()
    work(settings, mathematics.parts, stop=stop)
