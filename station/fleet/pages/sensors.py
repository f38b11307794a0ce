"""The calibrations in force by sensor: how old, how good, what the last night found, when due."""

from collections.abc import Sequence
from datetime import datetime, timedelta

from station.fleet.overview import SensorHealth
from station.fleet.pages.addresses import SENSORS
from station.fleet.pages.frame import page
from station.fleet.pages.parts import UNKNOWN, badge, card, empty, mm, nowrap, table, two_lines
from station.fleet.wording import moment, span
from station.report import Child, Markup, element, minus

_SOON = 0.9
"""Of the time until it is due: from there on somebody should plan a visit."""


def sensors_card(healths: Sequence[SensorHealth], due_after: timedelta) -> Markup:
    """Return the sensors and rigs that somebody has to see to, and the way to all of them."""
    if not healths:
        none = "No calibration is in force anywhere."
        return card("Sensors", empty(none), id_="sensors")
    wanted = [each for each in healths if _wants(each, due_after)]
    all_of_them = element("a", f"Calibrations in force: {len(healths)}", href=SENSORS)
    shown: Child = (
        _table("Sensors to see to", wanted, due_after)
        if wanted
        else empty(f"None is in doubt, none is due: {due_after.days} days after it was made.")
    )
    return card("Sensors to see to", shown, element("p", all_of_them), id_="sensors")


def sensors_page(healths: Sequence[SensorHealth], due_after: timedelta, at: datetime) -> str:
    """Return the page of all sensors and rigs."""
    title = "Calibrations in force"
    said = (
        f"As the fleet knew them at {moment(at)}; due {due_after.days} days after they were made."
    )
    return page(
        title,
        element("h1", title),
        element("p", said, class_="hint"),
        card("Sensors and rigs", _table(title, healths, due_after))
        if healths
        else empty("No calibration is in force anywhere."),
    )


def _table(caption: str, healths: Sequence[SensorHealth], due_after: timedelta) -> Markup:
    heads = ("Sensor", "Health", "Calibration", "Age", "Last night", "Drift rms", "Dots, stripe")
    return table(caption, heads, (_row(each, due_after) for each in healths))


def _row(health: SensorHealth, due_after: timedelta) -> tuple[Child, ...]:
    name = health.name if health.of == "sensor" else f"rig {health.name}"
    return (
        element("span", name, element("span", health.station, class_="below")),
        _verdict(health, due_after),
        two_lines(health.calibration_id, f"version {health.version}"),
        two_lines(span(health.age_s), f"due {health.created_at + due_after:%Y-%m-%d}"),
        _night(health),
        _drift(health),
        two_lines(_px(health.rms_dots_px), _px(health.rms_stripe_px)),
    )


def _night(health: SensorHealth) -> Markup:
    if health.checked_at is None:
        return nowrap(UNKNOWN)
    return two_lines(health.outcome or UNKNOWN, moment(health.checked_at))


def _drift(health: SensorHealth) -> Markup:
    if health.drift_largest_mm is None:
        return nowrap(mm(health.drift_rms_mm, 3))
    return two_lines(mm(health.drift_rms_mm, 3), f"at most {mm(health.drift_largest_mm, 3)}")


def _wants(health: SensorHealth, due_after: timedelta) -> bool:
    soon = health.age_s >= _SOON * due_after.total_seconds()
    return health.doubtful or health.passed is False or soon


def _verdict(health: SensorHealth, due_after: timedelta) -> Markup:
    due_s = due_after.total_seconds()
    if health.doubtful:
        return badge("in doubt", "bad")
    if health.passed is False:
        return badge("did not pass", "bad")
    if health.age_s >= due_s:
        return badge("overdue", "warn")
    return badge("due soon", "warn") if health.age_s >= _SOON * due_s else badge("good", "good")


def _px(value: float | None) -> str:
    return UNKNOWN if value is None else f"{minus(f'{value:.3f}')}\N{NARROW NO-BREAK SPACE}px"
