"""Where the wheels go: one table, or a folder of tables."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from station.documents import MeasurementDocument, WheelDocument
from station.errors import InputUnusable
from station.exports import table_writer
from station.replay.forms import Form, wheels_in
from station.replay.parts import Part

_PARTS = ".parts"
_URL = re.compile(r"([a-z][a-z0-9+.-]+):/+(.*)")
"""Of one taken for a path there is one slash left."""


@dataclass(frozen=True, slots=True)
class Target:
    """What `--out` names.

    Attributes
    ----------
    out
        The table, or the folder.
    parts
        The folder of parts: that one, or one beside the table for as long as it is not made.
    form
        Of the parts.
    """

    out: Path
    parts: Path
    form: Form

    @classmethod
    def of(cls, out: Path) -> "Target":
        """Return what a name stands for: a table by its ending, a folder where it has none.

        Raises
        ------
        InputUnusable
            If it is a URL, or its ending is that of no table.
        """
        url = _URL.match(str(out))
        if url is not None:
            raise InputUnusable(
                f"--out {url[1]}://{url[2]}: not supported, tables are written to disks of this "
                "machine alone; give a path, and copy what comes of it"
            )
        if out.is_dir() or not out.suffix:
            return cls(out, out, Form.PARQUET)
        table_writer(out)
        form = Form.WHEELS if out.suffix == ".json" else Form.ROWS
        return cls(out, out.with_name(out.name + _PARTS), form)

    @property
    def is_folder(self) -> bool:
        """Whether the parts are what was asked for."""
        return self.out == self.parts

    def join(self, heading: MeasurementDocument, parts: Sequence[Part]) -> tuple[int, int]:
        """Make the table of parts, in their order; return how many wheels it has, and measured.

        Raises
        ------
        InputUnusable
            If a part is damaged, or the table cannot be written.
        """
        if self.is_folder:
            return _counted([part.path for part in parts])
        count = measured = 0

        def wheels() -> Iterator[WheelDocument]:
            nonlocal count, measured
            for part in parts:
                for wheel in wheels_in(part.path):
                    count += 1
                    measured += wheel.reason is None
                    yield wheel

        table_writer(self.out)(self.out, heading, wheels())
        return count, measured


def _counted(paths: Sequence[Path]) -> tuple[int, int]:
    if not paths:
        return 0, 0
    import duckdb  # noqa: PLC0415  costs 0.1 s, seldom used

    try:
        with duckdb.connect() as database:
            table = database.read_parquet([str(path) for path in paths])
            (found,) = table.aggregate("count(*), count(*) - count(reason)").fetchall()
    except duckdb.Error as error:
        said = str(error).splitlines()[0]
        raise InputUnusable(f"{said}; remove that part and replay again") from error
    wheels, measured = found
    return wheels, measured
