"""What one look at the station found."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum

from station.capture import CaptureStatus
from station.watching.troubles import Severity, Trouble


class Condition(StrEnum):
    """How a part of the station is."""

    READY = "ready"
    DEGRADED = "degraded"
    """It does its work, and somebody should look at it."""
    NOT_READY = "not_ready"


@dataclass(frozen=True, slots=True)
class PartState:
    """How a part is, and the gravest reason for it."""

    condition: Condition
    trouble: Trouble | None = None

    @property
    def since(self) -> datetime | None:
        """When it became so, where it is not as it should be."""
        return None if self.trouble is None else self.trouble.since


_STATE_AT = {Severity.CRITICAL: Condition.NOT_READY, Severity.WARNING: Condition.DEGRADED}
_GRAVEST_FIRST = tuple(Severity)


@dataclass(frozen=True, slots=True)
class Outlook:
    """The station at one moment.

    Attributes
    ----------
    parts
        The names of all parts, in order.
    troubles
        The gravest first.
    statuses
        Of the capture processes that answer, by sensor.
    """

    at: datetime
    parts: Sequence[str]
    troubles: Sequence[Trouble]
    statuses: Mapping[str, CaptureStatus]

    @property
    def ready(self) -> bool:
        """Whether the next train will be recorded and measured."""
        return all(each.severity is not Severity.CRITICAL for each in self.troubles)

    def part(self, name: str) -> PartState:
        """Return how a part is."""
        own = [each for each in self.troubles if each.part == name and each.severity in _STATE_AT]
        if not own:
            return PartState(Condition.READY)
        return PartState(_STATE_AT[own[0].severity], own[0])


def gravest_first(troubles: Sequence[Trouble]) -> list[Trouble]:
    """Return troubles in order: the gravest first, of equal ones the oldest."""
    return sorted(troubles, key=lambda each: (_GRAVEST_FIRST.index(each.severity), each.since))
