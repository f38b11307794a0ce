"""Measurements in the forms of other programs: rows of CSV or Parquet, a profile as MiniProf."""

import tempfile
from collections.abc import Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import Any, Final

from station.documents import MeasurementDocument, WheelDocument
from station.errors import NotFound
from station.exports import COLUMNS, miniprof_of, row_of, write_table
from station.store import AxleWheel, JsonObject, Measurement


class Form(StrEnum):
    """How a page of measurements is written."""

    JSON = "json"
    CSV = "csv"
    PARQUET = "parquet"


MEDIA_TYPE: Final = {Form.CSV: "text/csv", Form.PARQUET: "application/vnd.apache.parquet"}
_OWN: Final = {
    "id": "BIGINT",
    "pass": "VARCHAR",
    "measured_at": "TIMESTAMP WITH TIME ZONE",
    "rig_calibration": "VARCHAR",
}
TABLE_COLUMNS: Final = _OWN | COLUMNS
"""Those of `station measure --out`, with more before them; `recording` and `calibration` are the
station's ids, in place of a file's name and a fingerprint."""
_READING: Final = {"": "value", "_u95": "u95", "_status": "status", "_alarm": "alarm"}


def form_wanted(given: Form | None, accept: str) -> Form:
    """Return the form that a call wants: by its `format`, else the first that it accepts.

    >>> form_wanted(None, "text/csv;q=0.9, */*"), form_wanted(None, "*/*")
    (<Form.CSV: 'csv'>, <Form.JSON: 'json'>)
    """
    if given is not None:
        return given
    forms = {media: form for form, media in MEDIA_TYPE.items()} | {"application/json": Form.JSON}
    accepted = (each.partition(";")[0].strip().lower() for each in accept.split(","))
    return next((forms[media] for media in accepted if media in forms), Form.JSON)


def table_of(
    measurements: Sequence[Measurement], places: Mapping[int, AxleWheel], form: Form
) -> bytes:
    """Return measurements as a table, a row a wheel; `places` are theirs in the train."""
    rows = [_row(each, places.get(each.id)) for each in measurements]
    with tempfile.TemporaryDirectory(prefix="station-table-") as folder:
        out = Path(folder, f"table.{form}")
        write_table(out, TABLE_COLUMNS, rows)
        return out.read_bytes()


def miniprof_text(row: Measurement, axle: AxleWheel | None, profile: JsonObject | None) -> str:
    """Return the profile of a measurement as the text of a MiniProf file.

    Raises
    ------
    NotFound
        If it has none.
    """
    wheel = _wheel(row, axle, profile)
    if wheel.profile is None:
        raise NotFound(f"measurement {row.id} has no profile: {wheel.reason or 'none was kept'}")
    return miniprof_of(wheel, wheel.profile, _heading(row))


def _row(row: Measurement, axle: AxleWheel | None) -> dict[str, Any]:
    distance = {} if axle is None else axle.back_to_back or {}
    own = {
        "id": row.id,
        "pass": row.pass_id,
        "measured_at": row.measured_at.isoformat(),
        "recording": row.recording_id,
        "frame": row.frame,
        "calibration": row.calibration_id,
        "rig_calibration": row.rig_calibration_id,
    }
    told = {f"back_to_back{end}": distance.get(field) for end, field in _READING.items()}
    return row_of(_wheel(row, axle, None), _heading(row)) | own | told


def _wheel(row: Measurement, axle: AxleWheel | None, profile: JsonObject | None) -> WheelDocument:
    place: JsonObject = {}
    if axle is not None:
        place = {"axle": axle.number, "side": axle.side, "placing": axle.placing}
        place["wheelset"] = axle.wheelset
    return WheelDocument.model_validate({**row.wheel, **place, "profile": profile})


def _heading(row: Measurement) -> MeasurementDocument:
    return MeasurementDocument(
        created=row.measured_at,
        software=row.software,
        calibration=None,
        reference=row.reference,
        regime=row.regime,
        wheels=(),
    )
