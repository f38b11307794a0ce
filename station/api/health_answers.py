"""What comes out over HTTP of how the station is: for everybody, and for those with a key."""

from datetime import datetime
from typing import Self

from station.api.answers import Out
from station.watching import Condition, Outlook, PartState, Severity, Trouble, TroubleKind


class Health(Out):
    """The API answers."""

    status: str


class PartModel(Out):
    """How a part is; why in one word, as anybody may ask."""

    condition: Condition
    reason: TroubleKind | None
    since: datetime | None
    """When it became so, as far as this process knows; null where it is ready."""

    @classmethod
    def of(cls, part: PartState) -> Self:
        reason = None if part.trouble is None else part.trouble.kind
        return cls(condition=part.condition, reason=reason, since=part.since)


class Readiness(Out):
    """Which parts are ready; a part that is not says why.

    No addresses and no names of files: this is answered without a key. `/v1/station` says more.
    """

    ready: bool
    """Whether the next train will be recorded and measured; true where a part is degraded."""
    parts: dict[str, str]
    """`ready`, or why not; a degraded part is ready."""
    details: dict[str, PartModel]
    """The same for programs, with what is degraded."""

    @classmethod
    def of(cls, outlook: Outlook) -> Self:
        parts = {name: outlook.part(name) for name in outlook.parts}
        return cls(
            ready=outlook.ready,
            parts={name: _in_words(part) for name, part in parts.items()},
            details={name: PartModel.of(part) for name, part in parts.items()},
        )


def _in_words(part: PartState) -> str:
    unready = part.condition is Condition.NOT_READY and part.trouble is not None
    return part.trouble.public if unready and part.trouble else "ready"


class StationAlarmModel(Out):
    """Something that somebody should look at."""

    kind: TroubleKind
    severity: Severity
    """critical: the next train is not recorded or not measured; warning: readings miss or may be
    wrong; notice: somebody is waited for."""
    part: str
    since: datetime
    what: str
    cure: str
    """What to do."""

    @classmethod
    def of(cls, trouble: Trouble) -> Self:
        return cls(**{name: getattr(trouble, name) for name in cls.model_fields})
