"""The fleet in lines for people."""

from collections.abc import Sequence
from datetime import datetime

from station.fleet import FleetQuantity, FleetTrend, SensorHealth, StationState

_DAY_S = 86_400.0
_CLOCK_S = 5.0
"""Beyond it a clock is worth a word; the way to the fleet is part of what is seen."""


def status_text(states: Sequence[StationState]) -> str:
    """Return a line for each station."""
    if not states:
        return "no station has sent anything yet"
    head = ("station", "heard", "to send", "passes", "last pass", "remarks")
    return _columns([head, *(_state(each) for each in states)])


def _state(state: StationState) -> tuple[str, ...]:
    return (
        state.station,
        f"{_span(state.silent_s)} ago",
        str(state.unsent),
        str(state.passes),
        _moment(state.last_pass_at),
        "; ".join(_remarks(state)) or "-",
    )


def _remarks(state: StationState) -> list[str]:
    clock = state.clock_ahead_s
    found = {
        f"calibration in doubt: {', '.join(state.doubtful)}": bool(state.doubtful),
        f"{state.alarms} alarms in its last pass": state.alarms > 0,
        f"its clock is {_span(abs(clock))} {'ahead' if clock > 0 else 'behind'}": abs(clock)
        > _CLOCK_S,
        f"{state.refused} changes not taken": state.refused > 0,
        f"epoch {state.epochs} of its store": state.epochs > 1,
        "SEVERAL STORES SEND UNDER ITS NAME": state.rivals > 0,
    }
    return [text for text, holds in found.items() if holds]


def health_text(healths: Sequence[SensorHealth]) -> str:
    """Return a line for each sensor and rig."""
    if not healths:
        return "no calibration is in force anywhere"
    head = (
        "station",
        "sensor",
        "calibration",
        "age",
        "dots px",
        "stripe px",
        "checked",
        "found",
        "drift mm",
        "",
    )
    return _columns([head, *(_health(each) for each in healths)])


def _health(health: SensorHealth) -> tuple[str, ...]:
    return (
        health.station,
        health.name if health.of == "sensor" else f"rig {health.name}",
        health.calibration_id,
        _span(health.age_s),
        _figure(health.rms_dots_px, 3),
        _figure(health.rms_stripe_px, 3),
        _moment(health.checked_at),
        health.outcome or "-",
        _figure(health.drift_rms_mm, 3),
        "IN DOUBT" if health.doubtful else "",
    )


def trend_text(trend: FleetTrend) -> str:
    """Return, for each wheel and quantity, its last value, its wear and the stations' offsets."""
    lines = [f"wheelset {trend.wheelset}, measured at {', '.join(trend.stations)}"]
    for side in trend.sides:
        head = ("quantity", "values", "last mm", "u95", "at", "wear mm/day", "stations")
        rows = [(name.value, *_quantity(found)) for name, found in side.quantities.items()]
        lines += ["", f"{side.side.value} wheel", _columns([head, *rows])]
    return "\n".join(lines)


def _quantity(found: FleetQuantity) -> tuple[str, ...]:
    last = found.values[-1]
    agreement = found.agreement
    wear, said = "-", f"{last.station} alone"
    if agreement is not None:
        wear = f"{agreement.per_day.value_mm:+.4f} ± {agreement.per_day.u95_mm:.4f}"
        said = "; ".join(
            f"{each.station} {each.offset_mm:+.3f} ± {each.u95_mm:.3f} of "
            f"{agreement.held_against}{'' if each.agrees else ' DISAGREES'}"
            for each in agreement.offsets
        )
    return (
        str(len(found.values)),
        f"{last.value:.3f}",
        f"{last.u95:.3f}",
        last.station,
        wear,
        said,
    )


def _columns(rows: Sequence[Sequence[str]]) -> str:
    widths = [max(len(cell) for cell in column) for column in zip(*rows, strict=True)]
    lines = (
        "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip()
        for row in rows
    )
    return "\n".join(lines)


def _figure(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"


def _moment(moment: datetime | None) -> str:
    return "-" if moment is None else f"{moment:%Y-%m-%d %H:%M} UTC"


def _span(seconds: float) -> str:
    if seconds < 120.0:
        return f"{max(seconds, 0.0):.0f} s"
    if seconds < 7200.0:
        return f"{seconds / 60.0:.0f} min"
    if seconds < 2.0 * _DAY_S:
        return f"{seconds / 3600.0:.0f} h"
    return f"{seconds / _DAY_S:.0f} days"
