"""Recordings of wheels that a sensor without any doubt has seen, and its calibration."""

from datetime import UTC, datetime

from station.documents import (
    CalibrationDocument,
    CameraDocument,
    MountingDocument,
    PlaneDocument,
    RmsDocument,
)
from station.recording import RotatingWriter, Rotation
from station.scenes import WheelScene, paper_sensor, trackside_mounting

SAME_WHEEL_MS, NEXT_WHEEL_MS = 19, 500
START_NS = 1_760_000_000_000_000_000
ONE_FILE = Rotation()
FILE_FOR_EACH_FRAME = Rotation(size_bytes=1)


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


def views_of(wheel, offsets_mm, rng, *, seed):
    """Return pictures of one wheel as it rolls through the light."""
    sensor, mounting = paper_sensor(), trackside_mounting("left")
    return [
        WheelScene(sensor, mounting, wheel, axle_offset_mm=offset_mm, seed=seed).render(rng)
        for offset_mm in offsets_mm
    ]


def record(path, views_of_wheels, *, sensor="left", rotation=ONE_FILE):
    """Record wheels, each as its pictures, one after the other; return the files."""
    writer = RotatingWriter(path, sensor, rotation=rotation, metadata={"session": {"id": "p"}})
    frame_id, time_ns = 1, START_NS
    for views in views_of_wheels:
        for picture in views:
            height, width = picture.shape
            pixels = picture.data.cast("B")
            writer.write_frame(frame_id, time_ns, time_ns, pixels, width, height)
            writer._wait_for_closing()
            frame_id += 1
            time_ns += SAME_WHEEL_MS * 1_000_000
        time_ns += (NEXT_WHEEL_MS - SAME_WHEEL_MS) * 1_000_000
    return writer.finish({}).paths
