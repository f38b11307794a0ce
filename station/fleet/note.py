"""What the process that sends to the fleet tells the others of the station: a small file.

Not the store: where the fleet is away nothing of the station's is to be written to again and again.
"""

import json
from dataclasses import asdict, dataclass
from datetime import datetime
from pathlib import Path

NAME = "fleet.json"


@dataclass(frozen=True, slots=True)
class FleetNote:
    """How the sending goes.

    Attributes
    ----------
    since
        When this data folder first had a fleet to send to.
    reached_at
        When a round was done last; None before the first.
    number
        The last change that the fleet has, as far as the station knows.
    why
        Why the last round was not done; None where it was.
    """

    since: datetime
    reached_at: datetime | None = None
    number: int = 0
    why: str | None = None


def write_note(folder: Path, note: FleetNote) -> None:
    """Write the note; the file is whole at every moment.

    Raises
    ------
    OSError
        If the disk does not take it.
    """
    part = folder / f"{NAME}.part"
    part.write_text(json.dumps(asdict(note), default=datetime.isoformat), encoding="utf-8")
    part.replace(folder / NAME)


def read_note(folder: Path) -> FleetNote | None:
    """Return the note; None where there is none that can be read."""
    try:
        found = json.loads((folder / NAME).read_text(encoding="utf-8"))
        reached = found["reached_at"]
        return FleetNote(
            since=datetime.fromisoformat(found["since"]),
            reached_at=None if reached is None else datetime.fromisoformat(reached),
            number=int(found["number"]),
            why=found["why"],
        )
    except (OSError, ValueError, KeyError, TypeError):
        return None
