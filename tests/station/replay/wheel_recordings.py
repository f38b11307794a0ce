"""Recordings of wheels that a sensor without any doubt has seen, and its calibration."""

from datetime import UTC, datetime

import numpy as np

from station.documents import (
    CalibrationDocument,
    CameraDocument,
    MountingDocument,
    PlaneDocument,
    RmsDocument,
)
from station.recording import RecordingWriter
from station.scenes import WheelScene, WheelTruth, paper_sensor, trackside_mounting

FRAME_MS, WHEEL_MS = 19, 500
START_NS = 1_760_000_000_000_000_000


def true_calibration(sensor="left"):
    truth, mounting = paper_sensor(), trackside_mounting("left")
    a, b, c, d = truth.plane.coefficients.tolist()
    return CalibrationDocument(
        sensor=sensor,
        created=datetime(2026, 1, 1, tzinfo=UTC),
        software="none",
        method="joint",
        camera=CameraDocument.from_model(truth.camera),
        plane=PlaneDocument(a=a, b=b, c=c, d=d),
        plane_covariance=((0.0,) * 4,) * 4,
        rms=RmsDocument(dots_px=0.0, stripe_px=0.0),
        poses=(),
        quality={},
        options={},
        inputs=(),
        mounting=MountingDocument(
            rotation_vector=tuple(mounting.rotation_vector.tolist()),
            translation_mm=tuple(mounting.translation_mm.tolist()),
        ),
    )


def wheel_pictures():
    """Return the pictures of three wheels, two of each; the last wheel is not to be seen."""
    rng = np.random.default_rng(5)
    pictures = [
        WheelScene(
            paper_sensor(),
            trackside_mounting("left"),
            WheelTruth(tread_wear_mm=wear_mm),
            axle_offset_mm=offset_mm,
            seed=int(wear_mm),
        ).render(rng)
        for wear_mm in (1.0, 3.0)
        for offset_mm in (-20.0, 0.0)
    ]
    return [*pictures, *[np.zeros_like(pictures[0])] * 2]


def record(path, pictures, sensor="left", first_id=1):
    time_ns = START_NS
    with RecordingWriter(path) as writer:
        for frame_id, picture in enumerate(pictures, start=first_id):
            height, width = picture.shape
            pixels = picture.data.cast("B")
            writer.write_frame(sensor, frame_id, time_ns, time_ns, pixels, width, height)
            time_ns += (WHEEL_MS if frame_id % 2 == 0 else FRAME_MS) * 1_000_000
    return path
