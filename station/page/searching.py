"""What a person looks for in a list: the fields of the search, as they stand in the address bar."""

from datetime import date, datetime, time, timedelta
from typing import ClassVar, Literal
from urllib.parse import urlencode
from zoneinfo import ZoneInfo

from pydantic import BaseModel, ConfigDict, Field

from station.errors import InputUnusable
from station.store.lists import Span


class ListSearch(BaseModel):
    """The fields that all lists have; an empty one, as a form sends it, asks for nothing."""

    model_config = ConfigDict(frozen=True, populate_by_name=True)
    place: ClassVar[str]
    """The address of the list."""

    first: date | Literal[""] = Field(default="", alias="from")
    """The first day, in the station's zone."""
    last: date | Literal[""] = Field(default="", alias="to")
    """The last day."""
    before: str = Field(default="", max_length=256)
    """Where an older page begins."""

    @property
    def asks(self) -> bool:
        """Whether anything is left out."""
        return self.address != self.place

    @property
    def address(self) -> str:
        """Where the newest of those found are listed."""
        return self.older("")

    def older(self, cursor: str) -> str:
        """Return where those before a place in the list are listed; from the newest where empty."""
        given = self.model_dump(mode="json", by_alias=True) | {"before": cursor}
        query = urlencode({name: value for name, value in given.items() if value})
        return f"{self.place}?{query}" if query else self.place

    def span(self, zone: ZoneInfo | None) -> Span:
        """Return from the begin of the first day to the end of the last, in the station's zone.

        Raises
        ------
        InputUnusable
            If the last day comes before the first.
        """
        if self.first and self.last and self.last < self.first:
            raise InputUnusable(
                f"from {self.first} to {self.last}: the last day comes before the first"
            )
        since = _begin_of(self.first, zone) if self.first else None
        until = _begin_of(self.last + timedelta(days=1), zone) if self.last else None
        return Span(since, until)


def _begin_of(day: date, zone: ZoneInfo | None) -> datetime:
    begin = datetime.combine(day, time.min)
    # Without a zone in the settings the station shows the host's.
    return begin.astimezone() if zone is None else begin.replace(tzinfo=zone)
