"""What came of measuring recordings again."""

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
