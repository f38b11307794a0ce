"""The limits that readings are judged by, as the settings give them."""

from measure import PRESETS, Limit, Limits, Quantity
from station.settings import LimitSettings, LimitsSettings


def limits_of(settings: LimitsSettings) -> Limits:
    """Return a preset with the limits in the settings in place of its own."""
    preset = PRESETS[settings.preset]
    given = {Quantity(name): _limit(limit) for name, limit in settings.given.items()}
    if not given:
        return Limits(settings.regime or preset.regime, preset.of)
    # Readings judged by other figures must not claim the name of a regulation.
    regime = settings.regime or f"{preset.regime}, changed"
    return Limits(regime, {**preset.of, **given})


def _limit(settings: LimitSettings) -> Limit:
    return Limit(
        low_mm=float("-inf") if settings.low is None else settings.low,
        high_mm=float("inf") if settings.high is None else settings.high,
        warn_within_mm=settings.warn_within,
        jump_mm=settings.jump,
    )
