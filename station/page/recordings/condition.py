"""How a recording stands, in one word: of its row alone, nothing of it is opened."""

from enum import StrEnum

from station.store import Recording


class Condition(StrEnum):
    """What a recording is shown as; the texts of the page say each in words."""

    RUNNING = "running"
    WHOLE = "whole"
    LOSSY = "lossy"
    """Frames are missing."""
    CUT_SHORT = "cut_short"
    """A crash had cut it short; what was there was made whole."""
    EMPTY = "empty"
    DELETED = "deleted"
    UPLOADED = "uploaded"
    """It was read through when it came; how many frames there should be, nobody told."""

    @property
    def kind(self) -> str:
        """How its badge looks."""
        return _KINDS[self]


_KINDS = {
    Condition.RUNNING: "busy",
    Condition.WHOLE: "good",
    Condition.LOSSY: "warn",
    Condition.CUT_SHORT: "warn",
    Condition.EMPTY: "bad",
    Condition.DELETED: "",
    Condition.UPLOADED: "",
}


def condition_of(row: Recording) -> Condition:
    """Return how a recording stands; what is worst counts."""
    if row.deleted_at is not None:
        return Condition.DELETED
    if row.closed_at is None:
        return Condition.RUNNING
    if not row.recorded:
        return Condition.EMPTY
    if row.recovered:
        return Condition.CUT_SHORT
    if missing_in(row) or row.complete is False:
        return Condition.LOSSY
    return Condition.UPLOADED if row.sha256 is not None else Condition.WHOLE


def missing_in(row: Recording) -> int:
    """Return how many frames were exposed and are not in a recording."""
    return (row.lost or 0) + (row.refused or 0)
