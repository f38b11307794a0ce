"""Sending what is new, in order, batch by batch: nothing twice, whatever is cut off.

The mark, how far a store has told, stands in the fleet's database and moves with the rows: a batch
whose acknowledgement was lost is simply found there.  Before a batch is sent its token is kept in
the store.  A fleet that has a token the store does not know took it from a store that is no more:
this one was brought back from a backup, and goes on in a new epoch.
"""

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime

import structlog
from sqlalchemy.exc import DBAPIError, IntegrityError, StatementError

from measure import Limits
from station.fleet.connecting import Fleet
from station.fleet.packing import Packed, pack
from station.fleet.patience import Stop
from station.fleet.receiving import Batch, Mark, MarkMoved, Sender, hear, refuse, take
from station.fleet.told_limits import limits_as_told
from station.software import SOFTWARE
from station.store import Store, pass_in_progress
from station.store.changes import (
    ChangesLeft,
    begin_epoch,
    changes_after,
    changes_left,
    knows_push,
    note_push,
    store_epoch,
)

_CHANGES_IN_BATCH = 20
_ROWS_IN_BATCH = 2000
"""About 2 MB: a second on a slow link, and little to send again where it is cut."""
_log = structlog.get_logger()


@dataclass(frozen=True, slots=True)
class Pushed:
    """What a round has sent; `number` is the last change that the fleet has."""

    number: int
    changes: int
    rows: int
    left: ChangesLeft


class Pusher:
    """Sends what one station's store knows to the fleet.

    Parameters
    ----------
    station, name
        What the fleet knows the station by, and what it is called.
    limits
        What the station judges readings by.
    profiles
        Whether profiles are sent too.
    now
        The station's clock.
    changes_in_batch
        At most.
    """

    def __init__(
        self,
        store: Store,
        fleet: Fleet,
        *,
        station: str,
        name: str,
        limits: Limits,
        profiles: bool,
        now: Callable[[], datetime],
        changes_in_batch: int = _CHANGES_IN_BATCH,
    ) -> None:
        self._store = store
        self._fleet = fleet
        self._station = station
        self._name = name
        self._limits = limits_as_told(limits)
        self._profiles = profiles
        self._now = now
        self._changes_in_batch = changes_in_batch

    def push(self, stop: Stop) -> Pushed:
        """Send all that is new, unless a train passes: it waits for nobody.

        Raises
        ------
        StoreUnusable
            If the store or the fleet's database does not answer; what was sent stays.
        MarkMoved
            If another process sends for the same store.
        """
        sender, mark = self._meet()
        changes = rows = 0
        while not stop.is_set() and (batch := self._next(mark)) is not None:
            mark = self._send(sender, mark, batch)
            changes += len(batch.packed)
            rows += sum(packed.size for packed in batch.packed)
        return Pushed(mark.number, changes, rows, self._left(mark.number))

    def _meet(self) -> tuple[Sender, Mark]:
        """Return who sends and from where on; in a new epoch where the store was brought back."""
        with self._store.look() as session:
            epoch = store_epoch(session)
        sender = self._sender(epoch or self._begin(after=None))
        mark = self._hear(sender)
        if not self._sent(mark):
            told = sender.store_epoch
            sender = self._sender(self._begin(after=told))
            _log.warning(
                "store brought back from a backup: all of it is sent once more, in a new epoch",
                station=self._station,
                epoch=sender.store_epoch,
                before=told,
            )
            mark = self._hear(sender)
        return sender, mark

    def _sender(self, epoch: str) -> Sender:
        return Sender(self._station, self._name, SOFTWARE, epoch, self._limits)

    def _begin(self, *, after: str | None) -> str:
        with self._store.change() as session:
            return begin_epoch(session, after=after, at=self._now())

    def _hear(self, sender: Sender) -> Mark:
        try:
            with self._fleet.change() as session:
                mark = hear(session, sender, None, self._now())
        except IntegrityError as error:
            raise MarkMoved(
                f"station {sender.station!r}: another process made itself known under this name "
                "at the same moment"
            ) from error
        left = self._left(mark.number)
        with self._fleet.change() as session:
            return hear(session, sender, left, self._now())

    def _sent(self, mark: Mark) -> bool:
        """Tell whether it was this store that told what the fleet has of it."""
        if mark.token is None:
            return True
        with self._store.look() as session:
            return knows_push(session, mark.token)

    def _left(self, number: int) -> ChangesLeft:
        with self._store.look() as session:
            return changes_left(session, number)

    def _next(self, mark: Mark, *, most: int | None = None) -> Batch | None:
        """Return the next changes as they are at one moment, having kept their token."""
        with self._store.look() as session:
            if pass_in_progress(session) is not None:
                return None
            changes = changes_after(session, mark.number, limit=most or self._changes_in_batch)
            packed: list[Packed] = []
            for each in pack(session, changes, profiles=self._profiles):
                packed.append(each)
                if sum(one.size for one in packed) >= _ROWS_IN_BATCH:
                    break
            if not packed:
                return None
            number = packed[-1].number
            left = changes_left(session, number)
        # After it was read: a backup that has the token has all that is sent with it.
        with self._store.change() as session:
            token = note_push(session, number, at=self._now())
        return Batch(packed, number, token, left)

    def _send(self, sender: Sender, mark: Mark, batch: Batch) -> Mark:
        try:
            with self._fleet.change() as session:
                return take(session, sender, mark, batch, self._now())
        except (StatementError, ValueError) as error:
            if len(batch.packed) == 1:
                return self._refused(sender, mark, batch, error)
        return self._send_singly(sender, mark, batch)

    def _send_singly(self, sender: Sender, mark: Mark, batch: Batch) -> Mark:
        """Send a batch that was not taken one by one: the one at fault must not stop the rest."""
        while mark.number < batch.number:
            one = self._next(mark, most=1)
            if one is None:
                break
            mark = self._send(sender, mark, one)
        return mark

    def _refused(self, sender: Sender, mark: Mark, batch: Batch, error: Exception) -> Mark:
        cause = error.orig if isinstance(error, DBAPIError) else error
        why = " ".join(str(cause).replace("\0", "").split())[:500]
        (packed,) = batch.packed
        _log.error("the fleet refuses", kind=packed.kind.value, key=packed.key, why=why)
        with self._fleet.change() as session:
            return refuse(session, sender, mark, batch, why, self._now())
