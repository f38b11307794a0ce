"""What the API refuses before anything of the station is asked.

StationError
├── BodyRefused             the body of a call cannot be used
│   ├── BodyTooLarge        more than the call may carry
│   └── BodyTooSlow         not there within the time for it
├── PicturesBusy            too many wait for pictures already
├── IdempotencyKeyReused    the same Idempotency-Key came with another call
├── StateConflict
│   └── CallInProgress      the same call is being answered right now
└── KeyRefused
    └── TooManyBadKeys      this address has tried too many
"""

from station.errors import KeyRefused, StateConflict, StationError


class BodyRefused(StationError):
    """The body of a call cannot be used."""


class BodyTooLarge(BodyRefused):
    """The body is larger than the call may carry."""


class BodyTooSlow(BodyRefused):
    """The body was not there within the time for it."""


class PicturesBusy(StationError):
    """Too many calls wait for pictures already."""

    retry_after_s = 1


class IdempotencyKeyReused(StationError):
    """The same Idempotency-Key came with another call."""


class CallInProgress(StateConflict):
    """The same call, by its Idempotency-Key, is being answered right now."""

    retry_after_s = 1


class TooManyBadKeys(KeyRefused):
    """The address has tried too many keys that are none."""

    def __init__(self, message: str, *, retry_after_s: int) -> None:
        super().__init__(message)
        self.retry_after_s = retry_after_s
