"""Which keys are good."""

import secrets
import time
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from threading import Lock

import structlog
from sqlalchemy.exc import SQLAlchemyError

from station.api.refusals import TooManyBadKeys
from station.api.throttle import Throttle
from station.errors import KeyRefused
from station.operations import Station
from station.store.callers import (
    Caller,
    Scope,
    caller_logged_in,
    caller_of,
    digest,
    ensure_unguessable,
    note_use,
    used_lately,
)

_MOST_KNOWN = 256
_TRUSTED_S = 1.0
"""A key that was taken back or has expired opens nothing more so long after it, s."""
_log = structlog.get_logger()


@dataclass(frozen=True, slots=True)
class _Known:
    """A key that was good when it was looked up."""

    caller: Caller
    looked_up_s: float


class Gate:
    """Lets callers with a good key through.

    Parameters
    ----------
    admin_key
        A key that is good besides those of the store, from the environment of an automation.
    clock
        Seconds that never go back.

    Raises
    ------
    InputUnusable
        If that key is so short that it could be guessed.
    """

    def __init__(
        self,
        station: Station,
        admin_key: str | None,
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        if admin_key is not None:
            ensure_unguessable(admin_key)
        self._station = station
        self.environment_sha256 = None if admin_key is None else digest(admin_key)
        """Digest of the key of the environment, if there is one."""
        web = station.settings.web
        self._throttle = Throttle(allowance=web.bad_keys, refill_s=web.bad_key_every_s)
        self._clock = clock
        self._known: OrderedDict[str, _Known] = OrderedDict()
        """Keys and cookies that were good when they were looked up last, by their digests."""
        self._lock = Lock()

    def recall(self, credential: str) -> Caller | None:
        """Return whose key or cookie it is where that was looked up within the last second.

        A controller that asks often would otherwise have its key looked up for every call, in
        another thread, which takes as long as answering it.
        """
        known = self._known.get(digest(credential))
        lately = known is not None and self._clock() - known.looked_up_s < _TRUSTED_S
        return known.caller if known is not None and lately else None

    def admit(self, key: str, address: str) -> Caller:
        """Return whose key it is.

        A key that was good before is looked up even where others of the address were bad: behind
        one address may be many.

        Raises
        ------
        TooManyBadKeys
            If the address tried too many keys that are none.
        KeyRefused
            If it is nobody's, expired or revoked.
        """
        sha256 = digest(key)
        wait_s = self._throttle.wait_s(address)
        if wait_s > 0 and sha256 not in self._known:
            raise TooManyBadKeys(
                f"too many bad keys from {address}; try again in {wait_s} s with a good one",
                retry_after_s=wait_s,
            )
        looked_up_s = self._clock()
        caller = self._caller(key, sha256)
        self._remember(sha256, None if caller is None else _Known(caller, looked_up_s))
        if caller is None:
            self._throttle.note_bad_key(address)
            raise KeyRefused("the station does not accept this key; ask its administrator for one")
        return caller

    def admit_login(self, cookie: str) -> Caller:
        """Return who was let in with this cookie.

        One that is over is no bad key: the tabs of a browser go on asking when a shift has ended.

        Raises
        ------
        KeyRefused
            If the login has ended, or its key is no longer good.
        """
        looked_up_s, now = self._clock(), self._station.now()
        with self._station.store.look() as session:
            caller = caller_logged_in(
                session, cookie, environment_sha256=self.environment_sha256, at=now
            )
        known = None if caller is None else _Known(caller, looked_up_s)
        self._remember(digest(cookie), known)
        if caller is None:
            raise KeyRefused("the login has ended; log in again with your key")
        if not used_lately(caller, at=now):
            self._note_use(caller, now)
        return caller

    def forget(self, sha256: str) -> None:
        """Have a key or a cookie, by its hash, looked up again when it comes next."""
        self._remember(sha256, None)

    def _caller(self, key: str, sha256: str) -> Caller | None:
        if self.environment_sha256 is not None and secrets.compare_digest(
            sha256, self.environment_sha256
        ):
            return Caller("environment", frozenset({Scope.ADMIN}))
        store, now = self._station.store, self._station.now()
        with store.look() as session:
            caller = caller_of(session, key, at=now)
        if caller is not None and not used_lately(caller, at=now):
            self._note_use(caller, now)
        return caller

    def _note_use(self, caller: Caller, now: datetime) -> None:
        try:
            with self._station.store.change() as session:
                note_use(session, caller, at=now)
        except SQLAlchemyError as error:
            # A full disk must not close the station to those who could look what is the matter.
            _log.warning("use of a key not noted", key=caller.key_id, why=type(error).__name__)

    def _remember(self, sha256: str, known: _Known | None) -> None:
        with self._lock:
            self._known.pop(sha256, None)
            if known is not None:
                self._known[sha256] = known
                if len(self._known) > _MOST_KNOWN:
                    self._known.popitem(last=False)
