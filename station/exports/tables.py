"""Writing wheels as results.json, CSV or Parquet, one at a time whatever their number."""

import csv
import io
import tempfile
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, BinaryIO

from station.documents import MeasurementDocument, WheelDocument, written_whole
from station.errors import InputUnusable
from station.exports.rows import COLUMNS, POINT_COLUMNS, point_rows, row_of

WriteTable = Callable[[Path, MeasurementDocument, Iterable[WheelDocument]], None]
"""Writes a heading, whose own wheels are not looked at, and wheels to a path."""

Columns = Mapping[str, str]
Rows = Iterable[Mapping[str, Any]]
_POINT_SUFFIXES = (".csv", ".parquet")


def table_writer(out: Path) -> WriteTable:
    """Return what writes the kind of file that a name stands for.

    Raises
    ------
    InputUnusable
        If the name ends in none of the kinds.
    """
    writers = {".json": _write_json, ".csv": _write_table, ".parquet": _write_table}
    if out.suffix not in writers:
        raise InputUnusable(f"--out {out}; allowed: a name that ends in {', '.join(writers)}")
    return writers[out.suffix]


def check_table_name(out: Path, option: str) -> None:
    """Refuse a name that stands for no table of points.

    Raises
    ------
    InputUnusable
        If it ends neither in .csv nor in .parquet.
    """
    if out.suffix not in _POINT_SUFFIXES:
        kinds = ", ".join(_POINT_SUFFIXES)
        raise InputUnusable(f"{option} {out}; allowed: a name that ends in {kinds}")


def write_points(out: Path, wheels: Iterable[WheelDocument]) -> None:
    """Write the points of all profiles as one table, a row a point.

    Raises
    ------
    InputUnusable
        If the folder cannot be written.
    """
    numbered = enumerate(wheels, start=1)
    write_table(out, POINT_COLUMNS, (row for n, wheel in numbered for row in point_rows(n, wheel)))


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


def _write_table(out: Path, heading: MeasurementDocument, wheels: Iterable[WheelDocument]) -> None:
    write_table(out, COLUMNS, (row_of(wheel, heading) for wheel in wheels))


def write_table(out: Path, columns: Columns, rows: Rows) -> None:
    """Write rows as CSV or Parquet, as the ending of the name says; see `check_table_name`.

    Parameters
    ----------
    columns
        Names and SQL types.
    rows
        Values by column; what is absent stays empty.

    Raises
    ------
    InputUnusable
        If the folder cannot be written.
    """
    if out.suffix == ".parquet":
        _write_parquet(out, columns, rows)
        return
    with written_whole(out) as stream:
        _put_csv(stream, columns, rows)


def _put_csv(stream: BinaryIO, columns: Columns, rows: Rows) -> None:
    text = io.TextIOWrapper(stream, encoding="utf-8", newline="", write_through=True)
    table = csv.DictWriter(text, list(columns), lineterminator="\n")
    table.writeheader()
    table.writerows(rows)
    text.detach()


def _write_parquet(out: Path, columns: Columns, rows: Rows) -> None:
    import duckdb  # noqa: PLC0415  costs 0.1 s, seldom used

    try:
        with tempfile.TemporaryDirectory(dir=out.parent, prefix=f".{out.name}.") as folder:
            table, made = Path(folder, "table.csv"), Path(folder, "table.parquet")
            with table.open("wb") as stream:
                _put_csv(stream, columns, rows)
            with duckdb.connect() as database:
                # Its own extensions are all it needs; at the trackside there is nothing to load.
                database.execute("SET autoinstall_known_extensions = false")
                database.execute("SET TimeZone = 'UTC'")
                read = database.read_csv(str(table), header=True, dtype=dict(columns))
                read.write_parquet(str(made))
            made.replace(out)
    except OSError as error:
        raise InputUnusable(
            f"{out}: cannot be written ({error.strerror}); give a path in a folder you may write"
        ) from error
