"""A figure against its limit, and how figures are rounded in JSON."""

from typing import Annotated

import typer

from calib import FloatArray
from station.errors import NothingMeasurable

Limit = Annotated[
    float | None,
    typer.Option(metavar="MM", min=0.0, help="Largest allowed figure; exit code 1 above it."),
]


def hold_against(limit_mm: float | None, value_mm: float, what: str) -> None:
    """Pass a figure that is within its limit, or has none.

    Raises
    ------
    NothingMeasurable
        If it is above the limit, or not a number.
    """
    if limit_mm is not None and not value_mm <= limit_mm:
        raise NothingMeasurable(f"{what} is {value_mm:.4f} mm; the limit is {limit_mm:g} mm")


def rounded(values_mm: FloatArray) -> list[float]:
    """Return lengths to a hundredth of a micrometre."""
    return [round(float(value), 5) for value in values_mm]
