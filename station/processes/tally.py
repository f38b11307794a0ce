"""How often each process was started again, told by the supervisor to whoever wants to know."""

import json
from collections.abc import Mapping
from pathlib import Path


def write_tally(path: Path, restarts: Mapping[str, int]) -> None:
    """Write the restarts by process; the file is whole at every moment."""
    part = path.with_name(f"{path.name}.part")
    part.write_text(json.dumps(dict(restarts)))
    part.replace(path)


def read_tally(path: Path) -> dict[str, int]:
    """Return the restarts by process; nothing where no supervisor has written any.

    Raises
    ------
    OSError, ValueError
        If the file cannot be read.
    """
    try:
        found = json.loads(path.read_text())
    except FileNotFoundError:
        return {}
    return {str(name): int(count) for name, count in found.items()}
