"""Pictures that come with their own times and numbers, as those of a recording do."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from calib import Picture


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """One picture that is to be taken."""

    after_ns: int
    """Time from the start of the acquisition to its exposure."""
    block_id: int
    """Its number on the wire."""
    picture: Picture


@runtime_checkable
class Playback(Protocol):
    """A source that says when its pictures are taken; others are asked when the camera exposes.

    It takes the place of the camera's free run and of its trigger line alike: what triggered the
    pictures once triggers them again. A software trigger takes the next one at once.
    """

    def rewind(self) -> None:
        """Begin with the first picture: an acquisition starts."""

    def upcoming(self) -> Shot | None:
        """Return the next picture, again and again until it is taken; None after the last."""

    def take(self) -> None:
        """Go on to the picture after the upcoming one."""
