"""The fleet in lines for people."""

from collections.abc import Sequence

from station.fleet import (
    FleetQuantity,
    FleetTrend,
    SensorHealth,
    StationState,
    figure,
    moment,
    remarks_on,
    span,
)


def status_text(states: Sequence[StationState]) -> str:
    """Return a line for each station."""
    if not states:
        return "no station has sent anything yet"
    head = ("station", "heard", "to send", "passes", "last pass", "remarks")
    return _columns([head, *(_state(each) for each in states)])


def _state(state: StationState) -> tuple[str, ...]:
    return (
        state.station,
        f"{span(state.silent_s)} ago",
        str(state.unsent),
        str(state.passes),
        moment(state.last_pass_at),
        "; ".join(remarks_on(state)) or "-",
    )


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
        span(health.age_s),
        figure(health.rms_dots_px, 3),
        figure(health.rms_stripe_px, 3),
        moment(health.checked_at),
        health.outcome or "-",
        figure(health.drift_rms_mm, 3),
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
    if found.wear is not None:
        wear = f"{found.wear.per_day.value_mm:+.4f} ± {found.wear.per_day.u95_mm:.4f}"
    if agreement is not None:
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
