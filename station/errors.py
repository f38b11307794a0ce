"""Everything the station can fail with.

StationError
├── InputUnusable          what the caller gave cannot be used: exit 2, HTTP 400 or 422
├── NothingMeasurable      the work was done and the answer is no: exit 1
├── CameraError            the camera or its link
│   ├── CameraUnreachable  no camera answers at the address
│   ├── CameraRefused      the camera does not take a setting, or another host controls it
│   └── CameraLost         a camera in use stopped answering
├── RecordingError         the MCAP file or its disk
│   ├── RecordingUnreadable  not a recording, cut short, or damaged
│   └── DiskFull           no space left for what arrives
├── StoreUnusable          the database is damaged, out of reach, or busy for too long
│   └── StoreNewer         a newer version of the station has made it
├── NotFound               a name the station does not know
├── StateConflict          a command the present state forbids
├── VersionConflict        somebody else changed it since the caller read it
│   └── VersionMissing     the caller did not say which version it read
└── AccessRefused          the caller may not do this
    ├── KeyRefused         no key, or one the station does not accept
    └── ScopeMissing       the key does not carry the scope the call needs

A message is one line: what was seen, what is allowed, what to do.
"""


class StationError(Exception):
    """Base of all failures of the station; the message says what to do next."""


class InputUnusable(StationError):
    """What the caller gave cannot be used."""


class NothingMeasurable(StationError):
    """The work was done and the answer is no."""


class CameraError(StationError):
    """The camera or its link failed."""


class CameraUnreachable(CameraError):
    """No camera answers at the address."""


class CameraRefused(CameraError):
    """The camera does not take a setting, or another host controls it."""


class CameraLost(CameraError):
    """A camera in use stopped answering."""


class RecordingError(StationError):
    """The recording could not be written or read."""


class RecordingUnreadable(RecordingError):
    """Not a recording, cut short, or damaged."""


class DiskFull(RecordingError):
    """No space is left for what arrives."""


class StoreUnusable(StationError):
    """The database is damaged, out of reach, or busy for too long."""


class StoreNewer(StoreUnusable):
    """A newer version of the station has made the database."""


class NotFound(StationError):
    """The station does not know the name."""


class StateConflict(StationError):
    """The present state forbids the command; `state` is its name where there is one."""

    def __init__(self, message: str, *, state: str | None = None) -> None:
        super().__init__(message)
        self.state = state


class VersionConflict(StationError):
    """Somebody else changed it since the caller read it."""


class VersionMissing(VersionConflict):
    """The caller did not say which version it read."""


class AccessRefused(StationError):
    """The caller may not do this."""


class KeyRefused(AccessRefused):
    """There is no key, or the station does not accept it."""


class ScopeMissing(AccessRefused):
    """The key does not carry the scope the call needs."""
