"""Keys as an administrator sees them: never their texts, nor the hashes of those."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Literal

from station.store import Key
from station.store.callers import Caller, usable

Standing = Literal["good", "expired", "revoked"]


@dataclass(frozen=True, slots=True)
class KeyView:
    """A key that was made some time.

    Attributes
    ----------
    own
        Whether the person who looks is logged in with it.
    """

    id: str
    name: str
    scopes: Sequence[str]
    standing: Standing
    created_at: datetime
    expires_at: datetime | None
    revoked_at: datetime | None
    last_used_at: datetime | None
    own: bool

    @classmethod
    def of(cls, key: Key, *, at: datetime, caller: Caller) -> "KeyView":
        """Return a key as it is at a moment, for somebody who looks."""
        return cls(
            id=key.id,
            name=key.name,
            scopes=key.scopes["scopes"],
            standing=_standing(key, at),
            created_at=key.created_at,
            expires_at=key.expires_at,
            revoked_at=key.revoked_at,
            last_used_at=key.last_used_at,
            own=key.id == caller.key_id,
        )


def _standing(key: Key, at: datetime) -> Standing:
    if usable(key, at=at):
        return "good"
    return "expired" if key.revoked_at is None else "revoked"


def key_views(keys: Sequence[Key], *, at: datetime, caller: Caller) -> list[KeyView]:
    """Return the keys that are good first, each kind newest first."""
    views = [KeyView.of(key, at=at, caller=caller) for key in reversed(keys)]
    return sorted(views, key=lambda view: view.standing != "good")
