"""Who works at the command line, as the audit trail keeps it."""

import getpass
import os

from station.store import Actor


def person() -> Actor:
    """Return the user of this process."""
    try:
        name = getpass.getuser()
    except (KeyError, OSError):  # a user without a name, as in a container
        name = f"user {os.getuid()}"
    return Actor(f"{name} at the command line")
