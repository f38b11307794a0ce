"""The limits that readings are judged by, as the settings give them."""

from dataclasses import replace

from measure import PRESETS, Limit, Limits, Quantity
from station.settings import LimitSettings, LimitsSettings, RangeSettings


def limits_of(settings: LimitsSettings) -> Limits:
    """Return a preset with the limits in the settings in place of its own."""
    preset = PRESETS[settings.preset]
    given = {Quantity(name): _limit(limit) for name, limit in settings.given.items()}
    back_to_back = settings.back_to_back
    if not given and back_to_back is None:
        return Limits(settings.regime or preset.regime, preset.of, preset.back_to_back)
    # Readings judged by other figures must not claim the name of a regulation.
    regime = settings.regime or f"{preset.regime}, changed"
    between = preset.back_to_back if back_to_back is None else _range(back_to_back)
    return Limits(regime, {**preset.of, **given}, between)


def _limit(settings: LimitSettings) -> Limit:
    found = _range(settings)
    return replace(found, warn_within_mm=settings.warn_within, jump_mm=settings.jump)


def _range(settings: RangeSettings) -> Limit:
    return Limit(
        low_mm=float("-inf") if settings.low is None else settings.low,
        high_mm=float("inf") if settings.high is None else settings.high,
        warn_within_mm=0.0,
    )
