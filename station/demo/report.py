"""The demo's answer for people: measured beside true."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from calib import Method
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
        "wheels": [asdict(wheel) for wheel in result.wheels],
        "rms_mm": {
            method.value: {
                quantity.value: reading_rms_mm(_of(result, method), quantity.value)
                for quantity in JUDGED
            }
            for method in Method
        },
    }


def as_text(result: DemoResult) -> str:
    """Return the tables that a person reads."""
    tables = [_frames(result), _planes(result), _wheels(result), _errors(result)]
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


def _wheels(result: DemoResult) -> Table:
    rows: list[dict[str, Value]] = [
        {
            "wheel": f"{wheel.sensor} {wheel.axle}",
            **{quantity.value: _beside(wheel, quantity.value) for quantity in JUDGED},
        }
        for wheel in _of(result, Method.JOINT)
    ]
    note = "Calibrated by joint; u95 is the half-width of the 95 % interval."
    return Table("Wheels: read ± u95 (true), mm", rows, (note,))


def _beside(wheel: WheelJudgement, quantity: str) -> str:
    value, u95 = wheel.read[quantity], wheel.u95[quantity]
    read = "missing" if value is None else f"{value:.3f} ± {u95:.3f}"
    return f"{read} ({wheel.true[quantity]:.3f})"


def _errors(result: DemoResult) -> Table:
    rows: list[dict[str, Value]] = [
        {
            "method": method.value,
            **{q.value: _shown(reading_rms_mm(_of(result, method), q.value)) for q in JUDGED},
        }
        for method in Method
    ]
    return Table("Error of the readings, mm RMS over all wheels", rows)


def _shown(rms_mm: float | None) -> str:
    return "a wheel is missing" if rms_mm is None else f"{rms_mm:.4f}"


def _of(result: DemoResult, method: Method) -> Sequence[WheelJudgement]:
    return [wheel for wheel in result.wheels if wheel.method == method]
