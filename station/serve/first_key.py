"""The first admin key: made when there was never one, and told once."""

import os
from collections.abc import Callable
from pathlib import Path

from station.operations import DataLayout, utc_now
from station.store import Store
from station.store.callers import Scope, add_key, any_key

NAME = "first admin"
Say = Callable[[str], None]


def ensure_first_key(layout: DataLayout, say: Say, *, to_a_person: bool) -> None:
    """Make a key where the station never had one.

    What a person at a terminal reads is gone with the window.  Anything else that takes stderr, as
    a journal or a file, keeps it for others to read: then the key is put into a file of this user.

    Parameters
    ----------
    say
        Where a line goes.
    to_a_person
        Whether that is a terminal.
    """
    store = Store.open(layout.store_url)
    try:
        with store.change() as session:
            if any_key(session):
                return
            key = add_key(session, NAME, [Scope.ADMIN], at=utc_now())
            if to_a_person:
                say(f"admin key, shown this once: {key}")
            else:
                _put_away(layout.root / "first-admin-key", key)
                say(
                    f"admin key: in {layout.root / 'first-admin-key'}, for this user alone; "
                    "delete that file once you have it"
                )
    finally:
        store.close()


def _put_away(path: Path, key: str) -> None:
    path.unlink(missing_ok=True)  # of a store that is no more
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o600)
    with os.fdopen(descriptor, "w") as file:
        file.write(f"{key}\n")
