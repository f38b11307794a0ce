"""Which recordings a person looks for."""

from typing import ClassVar, Literal
from zoneinfo import ZoneInfo

from pydantic import Field

from station.page.searching import ListSearch
from station.store.recordings_found import RecordingKind, RecordingSearch


class Search(ListSearch):
    """The fields of the search for recordings."""

    place: ClassVar[str] = "/recordings"

    name: str = Field(default="", max_length=128)
    """A piece of the name of a recording, its pass or its session."""
    sensor: str = Field(default="", max_length=32)
    kind: RecordingKind | Literal[""] = ""

    def wanted(self, zone: ZoneInfo | None) -> RecordingSearch:
        """Return what is looked for in the store; days are those of the station's zone.

        Raises
        ------
        InputUnusable
            If the last day comes before the first.
        """
        return RecordingSearch(
            name_holds=self.name.strip() or None,
            sensor=self.sensor or None,
            kind=self.kind or None,
            span=self.span(zone),
        )
