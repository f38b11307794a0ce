"""Wheels put aside on the disk until it is known which recordings were sound."""

import tempfile
from collections.abc import Collection, Iterator
from pathlib import Path
from types import TracebackType
from typing import Self

from station.documents import WheelDocument
from station.errors import InputUnusable


class Spool:
    """Takes any number of wheels and gives them back in order; nothing is left of it."""

    def __init__(self, folder: Path) -> None:
        """Make room in a folder.

        Raises
        ------
        InputUnusable
            If it does not exist or cannot be written.
        """
        try:
            self._file = tempfile.TemporaryFile(dir=folder)  # noqa: SIM115  closed by `__exit__`
        except OSError as error:
            raise InputUnusable(
                f"{folder}: cannot be written ({error.strerror}); give --out in a folder you may "
                "write"
            ) from error

    def add(self, wheel: WheelDocument) -> None:
        """Put a wheel aside."""
        self._file.write(wheel.model_dump_json().encode() + b"\n")

    def wheels(self, *, without: Collection[str]) -> Iterator[WheelDocument]:
        """Yield the wheels that are not of these sources."""
        self._file.seek(0)
        for line in self._file:
            wheel = WheelDocument.model_validate_json(line)
            if wheel.source not in without:
                yield wheel

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._file.close()
