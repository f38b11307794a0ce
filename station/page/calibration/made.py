"""All calibrations that were made, of sensors and rigs, the newest first."""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime

from sqlalchemy.orm import Session

from station.store import Calibration, RigCalibration
from station.store.lists import calibrations_page, rig_calibrations_page

_MOST = 40


@dataclass(frozen=True, slots=True)
class Made:
    """One calibration.

    Attributes
    ----------
    kind
        "sensor" or "rig"; `of` is its name.
    outcome
        "solving", "failed", "passed", "gates" (ready, but a gate failed) or "refused".
    """

    id: str
    kind: str
    of: str
    at: datetime
    method: str
    outcome: str
    reason: str | None


def made(session: Session) -> list[Made]:
    """Return what was made lately."""
    found = [*_of_sensors(session), *_of_rigs(session)]
    return sorted(found, key=lambda each: (each.at, each.id), reverse=True)[:_MOST]


def _of_sensors(session: Session) -> Iterator[Made]:
    for row in calibrations_page(session, limit=_MOST).rows:
        yield Made(
            row.id, "sensor", row.sensor, row.created_at, row.method, outcome_of(row), row.reason
        )


def _of_rigs(session: Session) -> Iterator[Made]:
    for row in rig_calibrations_page(session, limit=_MOST).rows:
        # One that was made elsewhere does not say how without its document.
        method = "boards" if row.ordered else "file"
        yield Made(row.id, "rig", row.rig, row.created_at, method, outcome_of(row), row.reason)


def outcome_of(row: Calibration | RigCalibration) -> str:
    """Return how a calibration came out, see `Made`."""
    if row.refused_at is not None:
        return "refused"
    if row.state.value != "ready":
        return row.state.value
    return "passed" if row.passed else "gates"
