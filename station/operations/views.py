"""What the operations hand out of a pass."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from sqlalchemy.orm import Session

from station.store import AxleWheel, Measurement, Pass, Recording, recordings_of, the
from station.trains import TrainPicture


@dataclass(frozen=True, slots=True)
class PassView:
    """A pass and what its sensors recorded."""

    row: Pass
    recordings: Sequence[Recording]


@dataclass(frozen=True, slots=True)
class PassWheels:
    """The wheels of a pass, each one's place in the train by its id, and the train."""

    row: Pass
    wheels: Sequence[Measurement]
    places: Mapping[int, AxleWheel]
    train: TrainPicture


def view_of(session: Session, pass_id: str) -> PassView:
    """Return a pass as it stands.

    Raises
    ------
    NotFound
        If there is none of that id.
    """
    row = the(session, Pass, pass_id)
    return PassView(row, recordings_of(session, row))
