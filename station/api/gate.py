"""Which keys are good."""

import secrets

from station.errors import KeyRefused
from station.operations import Station
from station.store import Caller, Scope, caller_of, digest, ensure_unguessable


class Gate:
    """Lets callers with a good key through.

    Parameters
    ----------
    admin_key
        A key that is good besides those of the store, from the environment of an automation.

    Raises
    ------
    InputUnusable
        If that key is so short that it could be guessed.
    """

    def __init__(self, station: Station, admin_key: str | None) -> None:
        if admin_key is not None:
            ensure_unguessable(admin_key)
        self._station = station
        self._admin_sha256 = None if admin_key is None else digest(admin_key)

    def admit(self, key: str) -> Caller:
        """Return whose key it is.

        Raises
        ------
        KeyRefused
            If it is nobody's, expired or revoked.
        """
        if self._admin_sha256 is not None and secrets.compare_digest(
            digest(key), self._admin_sha256
        ):
            return Caller("environment", frozenset({Scope.ADMIN}))
        with self._station.store.look() as session:
            caller = caller_of(session, key, at=self._station.now())
        if caller is None:
            raise KeyRefused("the station does not accept this key; ask its administrator for one")
        return caller
