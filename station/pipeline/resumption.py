"""Where the measuring of recordings goes on, all wheels before having been measured."""

from collections.abc import Mapping
from dataclasses import dataclass

from station.recording import BEGINNING, FilePlace


@dataclass(frozen=True, slots=True)
class Resumption:
    """A place between two wheels, or between one and the frames of nothing that part it from next.

    Attributes
    ----------
    places
        Of each sensor's recording; one that is not named begins at its beginning.
    shown_before
        Whether the series of frames that goes on there has shown a wheel already.
    """

    places: Mapping[str, FilePlace]
    shown_before: bool = False

    def of(self, sensor: str) -> FilePlace:
        """Return the place in the recording of a sensor."""
        return self.places.get(sensor, BEGINNING)
