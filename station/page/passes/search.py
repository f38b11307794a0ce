"""Which passes a person looks for."""

from typing import ClassVar, Literal

from pydantic import Field

from station.page.searching import ListSearch
from station.store import PassState


class Search(ListSearch):
    """The fields of the search for passes."""

    place: ClassVar[str] = "/passes"

    name: str = Field(default="", alias="id", max_length=64)
    """A piece of a pass's id."""
    train: str = Field(default="", max_length=128)
    """A piece of a train's name."""
    wheelset: str = Field(default="", max_length=64)
    """The whole name of a wheelset."""
    state: PassState | Literal[""] = ""
