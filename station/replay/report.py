"""What came of measuring recordings again, or would."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True, slots=True)
class Refusal:
    """A recording of which nothing is in the table, and why."""

    recording: str
    reason: str


@dataclass(frozen=True, slots=True)
class ReplayReport:
    """How much was measured, and what was refused."""

    out: Path
    recordings: int
    """Those in the table."""
    found_measured: int
    """Of these, those that an earlier run had measured."""
    frames: int
    """Frames that were read; those of refused recordings up to where they are damaged."""
    wheels: int
    """Rows of the table."""
    measured: int
    """Rows with readings; the others have a reason."""
    refused: tuple[Refusal, ...]

    def to_json(self) -> dict[str, Any]:
        """Return it as the command line prints it."""
        return {**asdict(self), "out": str(self.out), "refused": [asdict(r) for r in self.refused]}


@dataclass(frozen=True, slots=True)
class ReplayForecast:
    """What a replay would do."""

    out: Path
    recordings: int
    """Those that would be measured, or are."""
    tasks: int
    """A task measures one recording, or those of one pass."""
    found_measured: int
    """Tasks that an earlier run has done."""
    frames: int
    """Frames to read, about."""
    refused: tuple[Refusal, ...]

    def to_json(self) -> dict[str, Any]:
        """Return it as the command line prints it."""
        return {**asdict(self), "out": str(self.out), "refused": [asdict(r) for r in self.refused]}
