"""What comes out over HTTP of the audit trail."""

from datetime import datetime
from typing import Any, Self

from station.api.answers import Out
from station.store import AuditEntry


class AuditEntryModel(Out):
    """One change: who made it, when, from where."""

    id: int
    at: datetime
    who: str
    """The name of the key, or `station` where the station did it by itself."""
    address: str | None
    """Of the caller, where it came over the network."""
    action: str
    kind: str
    """Of thing that was changed."""
    subject: str
    """Its name."""
    before: dict[str, Any] | None
    after: dict[str, Any] | None

    @classmethod
    def of(cls, row: AuditEntry) -> Self:
        return cls(**{name: getattr(row, name) for name in cls.model_fields})


class AuditPage(Out):
    """Some entries; `next` is the `before` of the next page, absent on the last."""

    entries: list[AuditEntryModel]
    next: int | None
