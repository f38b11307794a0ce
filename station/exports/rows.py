"""A wheel as one flat row, its profile as a row a point: what tables and data frames take."""

from collections.abc import Iterator
from typing import Any

from measure import Quantity
from station.documents import MeasurementDocument, WheelDocument

_READING = {"": "DOUBLE", "_u95": "DOUBLE", "_status": "VARCHAR", "_alarm": "VARCHAR"}
_FIELDS = {"": "value", "_u95": "u95", "_status": "status", "_alarm": "alarm"}
_OF_AXLE = "back_to_back"
_QUALITY = {
    "points": "INTEGER",
    "coverage": "DOUBLE",
    "speckle_share": "DOUBLE",
    "axle_offset_mm": "DOUBLE",
    "sheet_yaw_deg": "DOUBLE",
    "wear_max_at_d_mm": "DOUBLE",
}
_CLAIMED = (
    Quantity.FLANGE_HEIGHT,
    Quantity.FLANGE_THICKNESS_10,
    Quantity.FLANGE_GRADIENT_QR,
)
_WHICH = {
    "recording": "VARCHAR",
    "sensor": "VARCHAR",
    "frame": "BIGINT",
}
_BETWEEN = " "
"""Between the names of sensors in one field: no name has one."""

COLUMNS: dict[str, str] = {
    **_WHICH,
    "frames": "INTEGER",
    "time": "TIMESTAMP WITH TIME ZONE",
    **{q.value + ending: kind for q in Quantity for ending, kind in _READING.items()},
    **_QUALITY,
    "reason": "VARCHAR",
    "calibration": "VARCHAR",
    "reference": "VARCHAR",
    "software": "VARCHAR",
    "regime": "VARCHAR",
    "axle": "INTEGER",
    "side": "VARCHAR",
    "placing": "VARCHAR",
    "wheelset": "VARCHAR",
    **{f"header_{quantity.value}": "DOUBLE" for quantity in _CLAIMED},
    "sensors": "VARCHAR",
    **{_OF_AXLE + ending: kind for ending, kind in _READING.items()},
}
"""Columns and their SQL types. Readings and `_u95` are in mm, empty where nothing was measured;
`frames` is how many showed the wheel, `calibration` the fingerprint of the one used, or of the rig,
`header_` what the header of a profile's file states, `sensors` those of a rig that gave points,
`back_to_back` the distance of its axle, in the rows of both wheels."""

POINT_COLUMNS: dict[str, str] = {
    "wheel": "INTEGER",
    **_WHICH,
    "d_mm": "DOUBLE",
    "h_mm": "DOUBLE",
    "sigma_mm": "DOUBLE",
    "wear_mm": "DOUBLE",
    "sensors": "VARCHAR",
}
"""Columns of the points of profiles; `wheel` counts the rows of the readings' table from 1,
`sensors` are those of a rig that saw the point."""


def row_of(wheel: WheelDocument, heading: MeasurementDocument) -> dict[str, Any]:
    """Return the row of a wheel, its values by column; None where there is none."""
    row: dict[str, Any] = _which(wheel) | {
        "frames": len(wheel.frames),
        "time": None if wheel.time is None else wheel.time.isoformat(),
    }
    for quantity, reading in wheel.readings.items():
        for ending, field in _FIELDS.items():
            row[quantity.value + ending] = getattr(reading, field)
    row |= {name: wheel.quality.get(name) for name in _QUALITY}
    row |= {"reason": wheel.reason, "calibration": heading.calibration_of(wheel)}
    row |= {"reference": heading.reference, "software": heading.software, "regime": heading.regime}
    row |= {"axle": wheel.axle, "side": wheel.side, "placing": wheel.placing}
    row |= {"wheelset": wheel.wheelset}
    claimed = wheel.header.claimed if wheel.header is not None else {}
    row |= {f"header_{quantity.value}": claimed.get(quantity) for quantity in _CLAIMED}
    row |= {"sensors": _BETWEEN.join(wheel.sensors) or None}
    distance = heading.back_to_back_of(wheel)
    return row | {_OF_AXLE + end: getattr(distance, field, None) for end, field in _FIELDS.items()}


def point_rows(number: int, wheel: WheelDocument) -> Iterator[dict[str, Any]]:
    """Yield the points of a wheel's profile, from the flange back to the field side."""
    profile = wheel.profile
    if profile is None:
        return
    wear = profile.wear_mm if profile.wear_mm is not None else (None,) * len(profile.d_mm)
    which = _which(wheel)
    points = zip(profile.d_mm, profile.h_mm, profile.sigma_mm, wear, strict=True)
    for place, (d, h, sigma, lost) in enumerate(points):
        point = {"d_mm": d, "h_mm": h, "sigma_mm": sigma, "wear_mm": lost}
        seen_by = _BETWEEN.join(profile.seen_by_names(place)) or None
        yield {"wheel": number, **which, **point, "sensors": seen_by}


def _which(wheel: WheelDocument) -> dict[str, Any]:
    return {"recording": wheel.source, "sensor": wheel.sensor, "frame": wheel.frame}
