"""The calls a trackside controller makes, in Python; the handbook has the same with curl.

A call that is cut off, or told to come again later, is made again by itself: see `Patience`.
"""

from station.client.connection import (
    Answer,
    CallRefused,
    Connection,
    Patience,
    StationUnreachable,
)
from station.client.station_client import StationClient

__all__ = [
    "Answer",
    "CallRefused",
    "Connection",
    "Patience",
    "StationClient",
    "StationUnreachable",
]
