"""A folder of parts, each the wheels of one task: what is in it need not be measured again.

A part is written beside its place and renamed, so that one is whole or not there.  Its name says
what it was made of; a replay that was killed finds what it had done by listing the folder.
"""

import os
import shutil
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from station.errors import InputUnusable, StateConflict
from station.replay.forms import Form
from station.replay.task import ReplayTask, Token

_UNFINISHED = ".part"
_MEANS_DIGITS = 12
_LONGEST_NAME = 200
_TELLING = 40
"""Characters of a recording's own name in that of its part."""


@dataclass(frozen=True, slots=True)
class Part:
    """A file, and the recordings whose wheels it holds."""

    path: Path
    tokens: frozenset[Token]

    @property
    def addresses(self) -> frozenset[str]:
        """Digests of where its recordings are."""
        return frozenset(token.address for token in self.tokens)


class PartFolder:
    """Parts of one form, made by the same means; those of others in the folder stay as they are.

    Raises
    ------
    InputUnusable
        If the folder cannot be made or written.
    """

    def __init__(self, folder: Path, form: Form, fingerprint: str, *, make: bool = True) -> None:
        self.folder, self._form = folder, form
        self._means = fingerprint[:_MEANS_DIGITS]
        self._by_address: dict[str, Part] = {}
        if make:
            _make(folder)
        for path in sorted(folder.glob(f"*.{self._means}.*{form.value}")):
            tokens = path.name.removesuffix(form.value).rpartition(".")[2].split("-")
            self._note(Part(path, frozenset(map(Token.parsed, tokens))))

    def of(self, task: ReplayTask) -> Part | None:
        """Return the whole part that holds the recordings of a task as they are now, if any."""
        (first, *_) = task.tokens
        part = self._by_address.get(first.address)
        if part is None or not task.tokens <= part.tokens or not self._form.is_whole(part.path):
            return None
        return part

    def put(self, name: str, tokens: Iterable[Token], content: bytes) -> Part:
        """Keep a part in place of what the folder had of the same recordings.

        Raises
        ------
        StateConflict
            If a part holds some of the recordings and others beside.
        InputUnusable
            If the disk takes no more.
        """
        held = frozenset(tokens)
        part = Part(self.folder / self._name(name, held), held)
        before = {
            known.path: known
            for token in held
            if (known := self._by_address.get(token.address)) is not None
        }
        for known in before.values():
            if not known.addresses <= part.addresses:
                raise StateConflict(
                    f"{known.path.name} holds an older reading of it together with other sensors' "
                    "recordings; replay all recordings of the pass, or remove that part"
                )
        _write(part.path, content)
        for path in before.keys() - {part.path}:
            path.unlink(missing_ok=True)
        self._note(part)
        return part

    def remove(self) -> None:
        """Remove the folder and all in it."""
        shutil.rmtree(self.folder)

    def _note(self, part: Part) -> None:
        self._by_address |= dict.fromkeys(part.addresses, part)

    def _name(self, name: str, tokens: frozenset[Token]) -> str:
        ending = f".{self._means}.{'-'.join(sorted(map(str, tokens)))}{self._form.value}"
        stem = Path(name.partition("::")[0]).stem
        telling = "".join(char if char.isalnum() or char in "-_" else "_" for char in stem)
        return telling[: max(1, min(_TELLING, _LONGEST_NAME - len(ending)))] + ending


def _make(folder: Path) -> None:
    try:
        folder.mkdir(exist_ok=True)
        if not os.access(folder, os.W_OK | os.X_OK):
            raise PermissionError(0, "no permission")
    except OSError as error:
        raise InputUnusable(
            f"{folder}: cannot be written ({error.strerror}); give --out in a folder you may write"
        ) from error


def _write(path: Path, content: bytes) -> None:
    unfinished = path.with_name(path.name + _UNFINISHED)
    try:
        with unfinished.open("wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        unfinished.replace(path)
    except OSError as error:
        unfinished.unlink(missing_ok=True)
        raise InputUnusable(
            f"{path}: cannot be written ({error.strerror}); make room and replay again, what was "
            "measured stays"
        ) from error
