"""Opening a session: what it may be of, and the target that a form describes."""

from dataclasses import dataclass
from datetime import datetime
from typing import Literal

from calib import CalibError, Target
from station.errors import InputUnusable
from station.operations import SessionOrder
from station.settings import StationSettings


@dataclass(frozen=True, slots=True)
class Choice:
    """A sensor or a rig that pictures can be taken with."""

    kind: str
    name: str

    @property
    def value(self) -> str:
        """As a form sends it."""
        return f"{self.kind}:{self.name}"


def choices_of(settings: StationSettings) -> tuple[Choice, ...]:
    """Return all sensors, then all rigs."""
    sensors = tuple(Choice("sensor", each.id) for each in settings.sensors)
    return (*sensors, *(Choice("rig", each.id) for each in settings.rigs))


def suggested_name(now: datetime) -> str:
    """Return a name for a session, which sorts by time.

    >>> suggested_name(datetime(2026, 7, 1, 14, 5))
    'session-20260701-1405'
    """
    return f"session-{now:%Y%m%d-%H%M}"


@dataclass(frozen=True, slots=True)
class TargetForm:
    """A target as a form describes it."""

    kind: Literal["dots", "chessboard"]
    rows: int
    cols: int
    pitch_mm: float
    dark: bool
    diameter_mm: float | None

    def target(self) -> Target:
        """Return the target.

        Raises
        ------
        InputUnusable
            If there is none like this.
        """
        dots = self.kind == "dots"
        try:
            return Target(
                kind=self.kind,
                rows=self.rows,
                cols=self.cols,
                pitch_mm=self.pitch_mm,
                dark=self.dark and dots,
                diameter_mm=self.diameter_mm if dots else None,
            )
        except CalibError as error:
            raise InputUnusable(str(error)) from error


def order_of(choice: str, target: Target) -> SessionOrder:
    """Return the order of a form; the operations refuse a sensor or rig that there is not.

    >>> order_of("rig:left", Target.parse("dots:7x8:12")).rig
    'left'
    """
    kind, _, name = choice.partition(":")
    return SessionOrder(target=target, rig=name) if kind == "rig" else SessionOrder(target, name)
