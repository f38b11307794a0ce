"""The parts of the set-up, and who sees them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from station.store.callers import Caller, Scope


@dataclass(frozen=True, slots=True)
class Part:
    """A part of the set-up: its name in the texts, its address, who may see it."""

    name: str
    address: str
    scope: Scope = Scope.READ


PARTS: Final = (
    Part("sensors", "/set-up"),
    Part("limits", "/set-up/limits"),
    Part("nightly", "/set-up/nightly"),
    Part("storage", "/set-up/storage"),
    Part("host", "/set-up/host"),
    Part("keys", "/set-up/keys", Scope.ADMIN),
    Part("audit", "/set-up/audit", Scope.ADMIN),
)


def parts_for(caller: Caller) -> Sequence[Part]:
    """Return the parts that a caller may see."""
    return [part for part in PARTS if caller.may(part.scope)]
