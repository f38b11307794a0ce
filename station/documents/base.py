"""What the JSON documents share: how they are read, written whole, and refused in one line."""

import os
import tempfile
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO, Self

from pydantic import BaseModel, ConfigDict, ValidationError

from station.errors import InputUnusable


class Document(BaseModel):
    """A JSON file with a contract."""

    model_config = ConfigDict(
        extra="ignore", frozen=True, use_attribute_docstrings=True, ser_json_inf_nan="null"
    )

    @classmethod
    def read(cls, path: Path) -> Self:
        """Read the document.

        Raises
        ------
        InputUnusable
            If there is no such file, it is not JSON, or not of this form.
        """
        try:
            return cls.model_validate_json(path.read_bytes())
        except OSError as error:
            raise InputUnusable(f"{path}: cannot be read ({error.strerror})") from error
        except ValidationError as error:
            first = error.errors()[0]
            where = ".".join(str(part) for part in first["loc"])
            raise InputUnusable(
                f"{path}: not a {cls.__name__}: {where + ': ' if where else ''}{first['msg']}; "
                "give a file that `station` wrote, or one of that form"
            ) from error

    def write(self, path: Path) -> None:
        """Write the document whole or not at all: a reader never sees half of it."""
        write_whole(path, self.model_dump_json(indent=2) + "\n")


def write_whole(path: Path, content: str | bytes) -> None:
    """Replace the file at `path` by `content`, text as UTF-8, in one step.

    Raises
    ------
    InputUnusable
        If the folder does not exist or cannot be written.
    """
    with written_whole(path) as stream:
        stream.write(content.encode() if isinstance(content, str) else content)


@contextmanager
def written_whole(path: Path) -> Generator[BinaryIO]:
    """Open a file that takes the place of the one at `path` when the block ends without error.

    Raises
    ------
    InputUnusable
        If the folder does not exist, cannot be written or is full.
    """
    try:
        descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        try:
            with os.fdopen(descriptor, "wb") as stream:
                yield stream
                stream.flush()
                os.fsync(stream.fileno())
            Path(name).chmod(0o644)
            Path(name).replace(path)
        except BaseException:
            Path(name).unlink(missing_ok=True)
            raise
    except OSError as error:
        raise InputUnusable(
            f"{path}: cannot be written ({error.strerror}); give a path in a folder you may write"
        ) from error
