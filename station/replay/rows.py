"""A wheel as one flat row: what tables and data frames take."""

from typing import Any

from measure import Quantity
from station.documents import MeasurementDocument, WheelDocument

_READING = {"": "DOUBLE", "_u95": "DOUBLE", "_status": "VARCHAR", "_alarm": "VARCHAR"}
_FIELDS = {"": "value", "_u95": "u95", "_status": "status", "_alarm": "alarm"}
_QUALITY = {
    "points": "INTEGER",
    "coverage": "DOUBLE",
    "speckle_share": "DOUBLE",
    "axle_offset_mm": "DOUBLE",
    "sheet_yaw_deg": "DOUBLE",
}

COLUMNS: dict[str, str] = {
    "recording": "VARCHAR",
    "sensor": "VARCHAR",
    "frame": "BIGINT",
    "frames": "INTEGER",
    "time": "TIMESTAMP WITH TIME ZONE",
    **{q.value + ending: kind for q in Quantity for ending, kind in _READING.items()},
    **_QUALITY,
    "reason": "VARCHAR",
    "calibration": "VARCHAR",
    "reference": "VARCHAR",
    "software": "VARCHAR",
}
"""Columns and their SQL types. Readings and `_u95` are in mm, empty where nothing was measured;
`frames` is how many showed the wheel, `calibration` the fingerprint of the one used."""


def row_of(wheel: WheelDocument, heading: MeasurementDocument) -> dict[str, Any]:
    """Return the row of a wheel, its values by column; None where there is none."""
    row: dict[str, Any] = {
        "recording": wheel.source,
        "sensor": wheel.sensor,
        "frame": wheel.frame,
        "frames": len(wheel.frames),
        "time": None if wheel.time is None else wheel.time.isoformat(),
    }
    for quantity, reading in wheel.readings.items():
        for ending, field in _FIELDS.items():
            row[quantity.value + ending] = getattr(reading, field)
    row |= {name: wheel.quality.get(name) for name in _QUALITY}
    row |= {"reason": wheel.reason, "calibration": heading.calibration}
    return row | {"reference": heading.reference, "software": heading.software}
