"""The audit trail: who changed what, when, from where; written with the change, or neither is.

Nothing here changes or deletes an entry, and triggers of the database refuse it to everybody else.
"""

from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum

from sqlalchemy.orm import Session

from station.store.tables import AuditEntry, JsonObject


@dataclass(frozen=True, slots=True)
class Actor:
    """Who makes a change; `address` where the call came over the network."""

    name: str
    address: str | None = None


STATION = Actor("station")
"""The station itself: by its schedule, its time-outs, its limits of the disk."""


class Action(StrEnum):
    """What was done."""

    ACTIVATE = "activate"
    ADD = "add"
    ANSWER = "answer"
    ARM = "arm"
    CANCEL = "cancel"
    CAPTURE = "capture"
    DELETE = "delete"
    FINISH = "finish"
    ORDER = "order"
    REFUSE = "refuse"
    RESTORE = "restore"
    REVOKE = "revoke"


def audit(
    session: Session,
    action: Action,
    kind: str,
    subject: str,
    *,
    by: Actor,
    at: datetime,
    before: JsonObject | None = None,
    after: JsonObject | None = None,
) -> None:
    """Add to the trail what the transaction of `session` changes.

    Parameters
    ----------
    kind, subject
        What sort of thing was changed, and its name.
    before, after
        What of it matters, as it was and as it is: never a secret.
    """
    session.add(
        AuditEntry(
            at=at,
            who=by.name,
            address=by.address,
            action=action,
            kind=kind,
            subject=subject,
            before=before,
            after=after,
        )
    )
