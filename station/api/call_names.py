"""Names for what a call makes: the same ones when the call comes again."""

import hashlib
from datetime import UTC, datetime

from station.store.callers import Call

_LETTERS = 32


class CallNames:
    """Gives one name after the other, which nobody can guess and another call never gets.

    A call with an `Idempotency-Key` whose API process died in the middle is made once more, and
    finds what it made before by its name.

    Examples
    --------
    >>> asked_at = datetime(2026, 7, 1, tzinfo=UTC)
    >>> names = CallNames(Call("controller", "k1", "f"), asked_at)
    >>> again = CallNames(Call("controller", "k1", "f"), asked_at)
    >>> first, second = names(), names()
    >>> (first, second) == (again(), again()), first == second, len(first)
    (True, False, 32)
    """

    def __init__(self, call: Call, asked_at: datetime) -> None:
        # With its moment: a key that is used anew after a day names other things.
        moment = asked_at.astimezone(UTC).isoformat()
        told = (call.caller, call.key, call.fingerprint, moment)
        self._seed = "\n".join(told)
        self._given = 0

    def __call__(self) -> str:
        """Return the next name."""
        self._given += 1
        return hashlib.sha256(f"{self._seed}\n{self._given}".encode()).hexdigest()[:_LETTERS]
