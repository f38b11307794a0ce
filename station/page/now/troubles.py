"""What is the matter with the station, and which of its pages helps."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

from station.watching import Trouble, TroubleKind

_LEADS_TO: Final[Mapping[TroubleKind, str]] = {
    TroubleKind.CALIBRATION_MISSING: "/calibration",
    TroubleKind.CALIBRATION_DOUBTFUL: "/calibration",
    TroubleKind.RECALIBRATION_ASKS: "/calibration",
    TroubleKind.RECALIBRATION_FAILED: "/calibration",
    TroubleKind.PASS_FAILED: "/passes",
    TroubleKind.FRAMES_LOST: "/recordings",
    TroubleKind.CAMERA_LOST: "/set-up",
    TroubleKind.CAMERA_UNFIT: "/set-up",
    TroubleKind.CLOCK_UNKEPT: "/set-up",
    TroubleKind.JOB_LATE: "#now-jobs",
}
_SAID_HERE: Final = frozenset({TroubleKind.RECALIBRATION_ASKS, TroubleKind.JOB_LATE})
"""Their cure is said for programs elsewhere; the page's texts have another."""


@dataclass(frozen=True, slots=True)
class TroubleNow:
    """A trouble as the page tells it."""

    told: Trouble
    cure_key: str | None
    """The text that says what to do; None where the trouble's own does."""
    leads_to: str | None
    """Where on the pages it can be looked at."""


def troubles_now(troubles: Iterable[Trouble]) -> list[TroubleNow]:
    """Return troubles as the page tells them, in their order."""
    return [
        TroubleNow(
            each,
            f"now.cure_of.{each.kind}" if each.kind in _SAID_HERE else None,
            _LEADS_TO.get(each.kind),
        )
        for each in troubles
    ]
