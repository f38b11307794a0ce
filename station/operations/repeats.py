"""Calls that come again: what they say of a pass must be what the first one said."""

from station.errors import StateConflict
from station.store import JsonObject, Pass, PassState
from station.trains import Consist, Named


def ensure_same(
    known: Pass, train: str | None, consist: Consist | None, *, again: bool = False
) -> None:
    """Let a call to open a pass come once more, if it says the same.

    One that has failed stays so, unless it may begin `again`.

    Raises
    ------
    StateConflict
        If the call names another train or consist, or the pass has failed.
    """
    if known.train != train:
        raise StateConflict(
            f"pass {known.id} is of train {known.train}, not of {train}; give a new pass a new id",
            state=known.state,
        )
    # One that was named when the train had gone is no part of the call that this one repeats.
    coming = known.consist is not None and known.consist["named"] == Named.COMING
    if consist is not None or coming:
        ensure_consist(known, consist, same_call=True)
    if known.state is PassState.FAILED and not again:
        raise StateConflict(
            f"pass {known.id} is {known.state} ({known.reason}); open a new one under a new id",
            state=known.state,
        )


def ensure_consist(known: Pass, consist: Consist | None, *, same_call: bool = False) -> None:
    """Let a call name a consist where the pass has none yet, or the same already.

    Raises
    ------
    StateConflict
        If it has another; of the `same_call`, also if it had none then.
    """
    if consist is None and not same_call:
        return
    present = None if known.consist is None else known.consist["wheelsets"]
    if present is None and not same_call:
        return
    if consist is None or present != consist.to_json()["wheelsets"]:
        raise StateConflict(
            f"pass {known.id} has {_named(present)}, not the consist of this call; give it once, "
            "when the train comes or when it has gone",
            state=known.state,
        )


def _named(wheelsets: list[JsonObject] | None) -> str:
    return "no consist" if wheelsets is None else f"a consist of {len(wheelsets)} wheelsets"
