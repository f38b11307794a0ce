"""Wheels that changed between two passes as wear does not change them."""

from collections.abc import Mapping, Sequence

from sqlalchemy.orm import Session

from measure import Jump, Limits, Placing, Quantity, jump_between
from station.store import AxleWheel, JsonObject, Measurement, Pass
from station.store.measured import Appearance, history_of
from station.trains.wheels import Seen, comparable


def jumps_of(
    session: Session,
    row: Pass,
    wheel: AxleWheel,
    measured: Mapping[int, Measurement],
    limits: Limits,
) -> JsonObject:
    """Return the jumps of a wheel against its wheelset's last pass, by quantity.

    None of a wheel whose place in the train is not certain: it may be another wheelset's.
    """
    if wheel.wheelset is None or wheel.measurement_id is None:
        return {}
    if wheel.placing is not Placing.CERTAIN:
        return {}
    before = history_of(session, wheel.wheelset, side=wheel.wheelset_side, before=row)
    history = [Seen.of(each) for each in before]
    own = measured[wheel.measurement_id]
    by = own.rig_calibration_id or own.calibration_id
    now = Seen.of(Appearance(row.id, row.opened_at, own.id, by, own.reference, own.wheel))
    found = {quantity: jump_to(history, now, quantity, limits) for quantity in limits.of}
    return {
        quantity.value: {
            "change": jump.change_mm,
            "u95": jump.u95_mm,
            "limit": jump.limit_mm,
            "before": since,
        }
        for quantity, answer in found.items()
        if answer is not None
        for jump, since in [answer]
    }


def jump_to(
    history: Sequence[Seen], now: Seen, quantity: Quantity, limits: Limits
) -> tuple[Jump, str] | None:
    """Return the jump of a quantity, and since which pass; None where there is none."""
    value = now.points.get(quantity)
    limit = limits.of.get(quantity)
    if value is None or limit is None:
        return None
    for earlier in reversed(history):
        before = earlier.points.get(quantity)
        if before is None or not comparable(earlier, now, quantity):
            continue
        jump = jump_between(before, value, limit)
        return None if jump is None else (jump, earlier.pass_id)
    return None
