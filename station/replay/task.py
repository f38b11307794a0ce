"""A recording by its files, and what is measured in one go."""

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

from station.software import SOFTWARE

_ADDRESS_DIGITS, _STATE_DIGITS = 10, 6


@dataclass(frozen=True, slots=True)
class Token:
    """What tells a recording, as it is now, from all others: part of a file's name.

    Attributes
    ----------
    address
        Digest of where it is.
    state
        Digest of what it is: the state of its files, its name in tables, the software.
    """

    address: str
    state: str

    @classmethod
    def of(cls, name: str, addresses: Sequence[str], states: Sequence[str]) -> "Token":
        """Make it of a recording's name, the addresses of its files and the state of each."""
        state = _digest(SOFTWARE, name, *addresses, *states)
        return cls(_digest(addresses[0])[:_ADDRESS_DIGITS], state[:_STATE_DIGITS])

    @classmethod
    def parsed(cls, text: str) -> "Token":
        """Return the token that was written as text."""
        return cls(text[:_ADDRESS_DIGITS], text[_ADDRESS_DIGITS:])

    def __str__(self) -> str:
        return self.address + self.state


@dataclass(frozen=True, slots=True)
class RecordingFiles:
    """A recording: the name that readings call it by, and its files in order."""

    name: str
    addresses: tuple[str, ...]
    """Paths, or URLs."""
    token: Token
    frames: int
    """How many there are, about where it has not been read yet."""


@dataclass(frozen=True, slots=True)
class ReplayTask:
    """What is measured in one go: a recording, or those of one pass by their sensors."""

    recordings: tuple[RecordingFiles, ...]
    sensors: tuple[str, ...] = ()
    """The sensor of each, where they are of one pass."""

    @property
    def name(self) -> str:
        """What messages call it."""
        return self.recordings[0].name

    @property
    def frames(self) -> int:
        """How many frames are to be read, about."""
        return sum(one.frames for one in self.recordings)

    @property
    def tokens(self) -> frozenset[Token]:
        """What is measured, as it is now."""
        return frozenset(one.token for one in self.recordings)

    @property
    def one_pass(self) -> dict[str, str]:
        """The name of each sensor's recording."""
        names = [one.name for one in self.recordings]
        return dict(zip(self.sensors, names, strict=True))


def _digest(*texts: str) -> str:
    return hashlib.sha256("\0".join(texts).encode()).hexdigest()
