"""The forms in which the wheels of one task are put down."""

import gzip
import io
import tempfile
from collections.abc import Iterable, Iterator
from enum import Enum
from pathlib import Path

from station.documents import MeasurementDocument, WheelDocument
from station.errors import InputUnusable
from station.exports import table_writer

_PARQUET = b"PAR1"


class Form(Enum):
    """How wheels are put down; the value is what the files' names end in."""

    ROWS = ".rows.gz"
    """On the way to a table of readings: a JSON document a line, without profiles."""
    WHEELS = ".wheels.gz"
    """On the way to results.json: the same with profiles."""
    PARQUET = ".parquet"
    """A table that stays as it is."""

    def encoded(self, heading: MeasurementDocument, wheels: Iterable[WheelDocument]) -> bytes:
        """Return wheels as the content of a file; the same wheels make the same bytes."""
        if self is Form.PARQUET:
            return _as_parquet(heading, wheels)
        stream = io.BytesIO()
        # No name and no time in its header.
        with gzip.GzipFile("", "wb", compresslevel=1, fileobj=stream, mtime=0) as lines:
            for wheel in wheels:
                kept = wheel if self is Form.WHEELS else wheel.model_copy(update={"profile": None})
                lines.write(kept.model_dump_json().encode() + b"\n")
        return stream.getvalue()

    def is_whole(self, path: Path) -> bool:
        """Tell whether a file can be read to its end."""
        try:
            if self is Form.PARQUET:
                return _begins_and_ends(path)
            with gzip.open(path) as stream:
                while stream.read(1 << 20):
                    pass
        except (OSError, EOFError):
            return False
        return True


def wheels_in(path: Path) -> Iterator[WheelDocument]:
    """Yield the wheels of a file that is no Parquet.

    Raises
    ------
    InputUnusable
        If it cannot be read to its end.
    """
    try:
        with gzip.open(path) as stream:
            for line in stream:
                yield WheelDocument.model_validate_json(line)
    except (OSError, EOFError) as error:
        raise InputUnusable(f"{path}: damaged ({error}); remove it and replay again") from error


def _as_parquet(heading: MeasurementDocument, wheels: Iterable[WheelDocument]) -> bytes:
    with tempfile.TemporaryDirectory(prefix="treadline-part-") as folder:
        path = Path(folder, "part.parquet")
        table_writer(path)(path, heading, wheels)
        return path.read_bytes()


def _begins_and_ends(path: Path) -> bool:
    size = path.stat().st_size
    with path.open("rb") as stream:
        begin = stream.read(len(_PARQUET))
        stream.seek(max(0, size - len(_PARQUET)))
        return size > 2 * len(_PARQUET) and begin == stream.read() == _PARQUET
