"""Recordings of wheels that two sensors of one rig, known without any doubt, have seen together."""

from datetime import UTC, datetime

import numpy as np
from wheel_recordings import NEXT_WHEEL_MS, ONE_FILE, SAME_WHEEL_MS, START_NS

from station.documents import (
    CalibrationDocument,
    CameraDocument,
    MountingDocument,
    PlaneDocument,
    RigDocument,
    RmsDocument,
    SurveyDocument,
    sensors_of,
)
from station.recording import RotatingWriter
from station.scenes import WheelRig, WheelTruth

NEW_YEAR = datetime(2026, 1, 1, tzinfo=UTC)
TRUTH = WheelRig.trackside("left")
RIGHT = WheelRig.trackside("right", prefix="right-")
INNER, OUTER = "inner", "outer"
RIG_WHEEL = WheelTruth("S1002", tread_wear_mm=2.5, flange_wear_mm=1.5)
TRIGGERS_APART_NS = 300_000


def calibration_of(name, *, with_mounting=True, truth=TRUTH):
    placed = truth.exact[name]
    a, b, c, d = placed.sensor.plane.coefficients.tolist()
    pose = placed.rig_from_camera
    mounting = MountingDocument(
        rotation_vector=tuple(pose.rotation_vector.tolist()),
        translation_mm=tuple(pose.translation_mm.tolist()),
    )
    return CalibrationDocument(
        sensor=name,
        created=NEW_YEAR,
        software="none",
        method="joint",
        camera=CameraDocument.from_model(placed.sensor.camera),
        plane=PlaneDocument(a=a, b=b, c=c, d=d),
        plane_covariance=((0.0,) * 4,) * 4,
        sensor_covariance=((0.0,) * 13,) * 13,
        rms=RmsDocument(dots_px=0.0, stripe_px=0.0),
        poses=(),
        quality={},
        options={},
        inputs=(),
        mounting=mounting if with_mounting else None,
    )


def true_rig(*, truth=TRUTH, **said):
    """Return the rig as a calibration without error finds it."""
    prints = {name: calibration_of(name, truth=truth).fingerprint for name in truth.exact.names}
    known = {
        "rig": "wheel",
        "side": "left",
        "created": NEW_YEAR,
        "software": "none",
        "method": "boards",
        "anchor": INNER,
        "sensors": sensors_of(truth.exact, prints),
        "covariance": truth.exact.covariance.tolist(),
        "survey": SurveyDocument(),
        "rms": RmsDocument(dots_px=0.0, stripe_px=0.0),
        "quality": {},
        "options": {},
        "inputs": (),
    }
    return RigDocument(**known | said)


def true_right_rig():
    return true_rig(truth=RIGHT, rig="right-wheel", side="right", anchor=f"right-{INNER}")


def shots_of(wheel, offsets_mm, rng, *, seed, truth=TRUTH, lateral_shift_mm=0.0):
    """Return the pictures of both sensors of a wheel that rolls through the light."""
    scenes = [
        truth.shot(wheel, axle_offset_mm=offset, lateral_shift_mm=lateral_shift_mm, seed=seed)
        for offset in offsets_mm
    ]
    return [{name: scene.render(rng) for name, scene in shot.items()} for shot in scenes]


def record_rig(folder, wheels, *, sensors=(INNER, OUTER), lost=(), session="p"):
    """Record wheels, each as its shots, one after the other; return the files by sensor.

    `lost` has (sensor, frame) of frames that never arrived.
    """
    writers = {
        name: RotatingWriter(
            folder / f"{name}.mcap",
            name,
            rotation=ONE_FILE,
            metadata={"session": {"id": session}},
        )
        for name in sensors
    }
    frame, time_ns = 1, START_NS
    for shots in wheels:
        for pictures in shots:
            for place, (name, writer) in enumerate(writers.items()):
                if (name, frame) not in lost:
                    _write(writer, frame, time_ns + place * TRIGGERS_APART_NS, pictures[name])
            frame += 1
            time_ns += SAME_WHEEL_MS * 1_000_000
        time_ns += (NEXT_WHEEL_MS - SAME_WHEEL_MS) * 1_000_000
    for writer in writers.values():
        writer.finish({})
    return {name: folder / f"{name}.mcap" for name in writers}


def _write(writer, frame, time_ns, picture):
    height, width = picture.shape
    pixels = np.ascontiguousarray(picture).data.cast("B")
    writer.write_frame(frame, time_ns, time_ns, pixels, width, height)
