"""Writing wheels as results.json, CSV or Parquet, one at a time whatever their number."""

import csv
import io
import tempfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import BinaryIO

from station.documents import MeasurementDocument, WheelDocument, written_whole
from station.errors import InputUnusable
from station.replay.rows import COLUMNS, row_of

WriteTable = Callable[[Path, MeasurementDocument, Iterable[WheelDocument]], None]
"""Writes a heading, whose own wheels are not looked at, and wheels to a path."""


def table_writer(out: Path) -> WriteTable:
    """Return what writes the kind of file that a name stands for.

    Raises
    ------
    InputUnusable
        If the name ends in none of the kinds.
    """
    writers = {".json": _write_json, ".csv": _write_csv, ".parquet": _write_parquet}
    if out.suffix not in writers:
        raise InputUnusable(f"--out {out}; allowed: a name that ends in {', '.join(writers)}")
    return writers[out.suffix]


def _write_json(out: Path, heading: MeasurementDocument, wheels: Iterable[WheelDocument]) -> None:
    """Write results.json: the same as of a `MeasurementDocument` with all wheels in it."""
    with written_whole(out) as stream:
        opened = heading.model_dump_json(exclude={"wheels"}).removesuffix("}")
        stream.write(f'{opened},"wheels":['.encode())
        before = b"\n"
        for wheel in wheels:
            stream.write(before + wheel.model_dump_json().encode())
            before = b",\n"
        stream.write(b"\n]}\n")


def _write_csv(out: Path, heading: MeasurementDocument, wheels: Iterable[WheelDocument]) -> None:
    with written_whole(out) as stream:
        _put_csv(stream, heading, wheels)


def _put_csv(
    stream: BinaryIO, heading: MeasurementDocument, wheels: Iterable[WheelDocument]
) -> None:
    text = io.TextIOWrapper(stream, encoding="utf-8", newline="", write_through=True)
    rows = csv.DictWriter(text, list(COLUMNS), lineterminator="\n")
    rows.writeheader()
    rows.writerows(row_of(wheel, heading) for wheel in wheels)
    text.detach()


def _write_parquet(
    out: Path, heading: MeasurementDocument, wheels: Iterable[WheelDocument]
) -> None:
    import duckdb  # noqa: PLC0415  costs 0.1 s, seldom used

    with tempfile.TemporaryDirectory(dir=out.parent, prefix=f".{out.name}.") as folder:
        table, made = Path(folder, "table.csv"), Path(folder, "table.parquet")
        with table.open("wb") as stream:
            _put_csv(stream, heading, wheels)
        with duckdb.connect() as database:
            # Its own extensions are all it needs; at the trackside there is nothing to download.
            database.execute("SET autoinstall_known_extensions = false")
            database.execute("SET TimeZone = 'UTC'")
            rows = database.read_csv(str(table), header=True, dtype=COLUMNS)
            rows.write_parquet(str(made))
        made.replace(out)
