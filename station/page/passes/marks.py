"""How a wheel stands: one mark, by colour, sign and word, from its readings and alarms."""

from collections.abc import Collection
from enum import StrEnum

from measure import Alarm


class Mark(StrEnum):
    """What a wheel is shown as; the texts of the page say each in words."""

    ALARM = "alarm"
    WARNING = "warning"
    FINE = "fine"
    UNMEASURED = "unmeasured"
    """It was seen, and nothing could be measured."""
    UNSEEN = "unseen"

    @property
    def sign(self) -> str:
        """What is drawn beside the colour."""
        return _SIGNS[self]

    @property
    def kind(self) -> str:
        """How its badge looks."""
        return _KINDS[self]


_SIGNS = {
    Mark.ALARM: "\u2715",
    Mark.WARNING: "!",
    Mark.FINE: "\u2713",
    Mark.UNMEASURED: "?",
    Mark.UNSEEN: "\u2013",
}
_KINDS = {
    Mark.ALARM: "bad",
    Mark.WARNING: "warn",
    Mark.FINE: "good",
    Mark.UNMEASURED: "",
    Mark.UNSEEN: "",
}


def mark_of(*, seen: bool, measured: bool, levels: Collection[Alarm]) -> Mark:
    """Return the mark of a wheel; a raised level counts before all else."""
    if Alarm.ALARM in levels:
        return Mark.ALARM
    if Alarm.WARNING in levels:
        return Mark.WARNING
    if measured:
        return Mark.FINE
    return Mark.UNMEASURED if seen else Mark.UNSEEN
