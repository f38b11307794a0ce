"""The demo's answer for people: measured beside true."""

from dataclasses import asdict
from typing import Any

from station.demo.judgement import JUDGED, WheelJudgement, reading_rms_mm
from station.demo.run import DemoResult
from station.tables import Table, Value


def as_data(result: DemoResult) -> dict[str, Any]:
    """Return everything as `--json` prints it."""
    return {
        "seed": result.seed,
        "good": result.good,
        "frames": [asdict(account) for account in result.frames],
        "planes": [asdict(plane) for plane in result.planes],
        "rigs": [asdict(rig) for rig in result.rigs],
        "wheels": [asdict(wheel) for wheel in result.wheels],
        "rms_mm": {
            quantity.value: reading_rms_mm(result.wheels, quantity.value) for quantity in JUDGED
        },
    }


def as_text(result: DemoResult) -> str:
    """Return the tables that a person reads."""
    tables = [
        _frames(result),
        _planes(result),
        _rigs(result),
        _wheels(result),
        _parts(result),
        _errors(result),
    ]
    return "\n\n".join(table.as_markdown() for table in tables)


def _frames(result: DemoResult) -> Table:
    return Table("Frames", [asdict(account) for account in result.frames])


def _planes(result: DemoResult) -> Table:
    rows: list[dict[str, Value]] = [
        {
            "sensor": plane.sensor,
            "method": plane.method,
            "plane error, mm RMS": plane.plane_rms_mm,
            "with its camera, mm RMS": plane.sheet_rms_mm,
            "normal off, deg": plane.normal_error_deg,
            "d off, mm": plane.offset_error_mm,
            "pictures used": plane.pictures_used,
        }
        for plane in result.planes
    ]
    return Table("Light planes beside the truth", rows)


def _rigs(result: DemoResult) -> Table:
    rows: list[dict[str, Value]] = [
        {
            "rig": rig.rig,
            "places off to each other, mm RMS": rig.places_rms_mm,
            "showings used": rig.showings_used,
        }
        for rig in result.rigs
    ]
    return Table("Rigs beside the truth", rows)


def _wheels(result: DemoResult) -> Table:
    rows: list[dict[str, Value]] = [
        {
            "wheel": _name(wheel),
            **{quantity.value: _beside(wheel, quantity.value) for quantity in JUDGED},
        }
        for wheel in result.wheels
    ]
    note = "Calibrated by joint; u95 is the half-width of the 95 % interval."
    return Table("Wheels: read ± u95 (true), mm", rows, (note,))


def _parts(result: DemoResult) -> Table:
    rows: list[dict[str, Value]] = [
        {
            "wheel": _name(wheel),
            "sensor": sensor,
            "part of the profile": ", ".join(f"{low:z.0f} to {high:z.0f}" for low, high in parts),
        }
        for wheel in result.wheels
        for sensor, parts in wheel.seen_mm.items()
    ]
    note = "The flange back is at 0, the tip near 15, the face near 30, the tape circle at 70."
    return Table("Which sensor saw what, mm from the flange back", rows, (note,))


def _errors(result: DemoResult) -> Table:
    row: dict[str, Value] = {
        q.value: _shown(reading_rms_mm(result.wheels, q.value)) for q in JUDGED
    }
    return Table("Error of the readings, mm RMS over all wheels", [row])


def _name(wheel: WheelJudgement) -> str:
    return f"{wheel.rig} {wheel.axle}"


def _beside(wheel: WheelJudgement, quantity: str) -> str:
    value, u95 = wheel.read[quantity], wheel.u95[quantity]
    read = "missing" if value is None else f"{value:.3f} ± {u95:.3f}"
    return f"{read} ({wheel.true[quantity]:.3f})"


def _shown(rms_mm: float | None) -> str:
    return "a wheel is missing" if rms_mm is None else f"{rms_mm:.4f}"
