"""The calibration of a simulated sensor that is known without any doubt."""

from datetime import UTC, datetime

from calib import FloatArray, LaserSensor
from station.documents import (
    CalibrationDocument,
    CameraDocument,
    MountingDocument,
    PlaneDocument,
    RmsDocument,
)
from station.scenes import paper_sensor, trackside_mounting
from station.software import SOFTWARE

_NO_DOUBT: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)


def exact_calibration(sensor_id: str, sensor: LaserSensor | None = None) -> CalibrationDocument:
    """Return a sensor, the paper's where none is given, surveyed on the left of the track."""
    sensor, rig_from_camera = sensor or paper_sensor(), trackside_mounting("left")
    a, b, c, d = sensor.plane.coefficients.tolist()
    return CalibrationDocument(
        sensor=sensor_id,
        created=datetime(2026, 1, 1, tzinfo=UTC),
        software=SOFTWARE,
        method="joint",
        camera=CameraDocument.from_model(sensor.camera),
        plane=PlaneDocument(a=a, b=b, c=c, d=d),
        plane_covariance=(_NO_DOUBT, _NO_DOUBT, _NO_DOUBT, _NO_DOUBT),
        rms=RmsDocument(dots_px=0.0, stripe_px=0.0),
        poses=(),
        quality={},
        options={},
        inputs=(),
        mounting=MountingDocument(
            rotation_vector=_three(rig_from_camera.rotation_vector),
            translation_mm=_three(rig_from_camera.translation_mm),
        ),
    )


def _three(values: FloatArray) -> tuple[float, float, float]:
    first, second, third = values.tolist()
    return first, second, third
