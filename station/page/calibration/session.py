"""A session as its page shows it."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from sqlalchemy import select

from station.guiding import Guidance
from station.operations import SessionView, Station
from station.store import Calibration, CalibrationSession, Recording, SessionState


@dataclass(frozen=True, slots=True)
class SessionShown:
    """A session, what it recorded, and what was solved from it."""

    row: CalibrationSession
    recordings: Sequence[Recording]
    calibrations: Sequence[Calibration]
    frames_a_pose: int

    @property
    def open(self) -> bool:
        """Whether pictures can be taken."""
        return self.row.state is SessionState.OPEN

    @property
    def solvable(self) -> bool:
        """Whether it can be calibrated from."""
        return self.row.state is SessionState.RECORDED and self.row.pictures > 0

    @property
    def of(self) -> str:
        """Name of the sensor or rig."""
        return self.row.sensor or self.row.rig or ""


def session_shown(station: Station, view: SessionView) -> SessionShown:
    """Return a session as its page shows it."""
    names = {each.id for each in view.recordings}
    sensors = [each.sensor for each in view.recordings]
    with station.store.look() as session:
        rows = session.scalars(
            select(Calibration)
            .where(Calibration.sensor.in_(sensors))
            .where(Calibration.created_at >= view.row.opened_at)
            .order_by(Calibration.created_at.desc())
        ).all()
    settings = [station.settings.sensor(name) for name in sensors]
    exposures = [len(each.calibration_exposures) for each in settings if each is not None]
    return SessionShown(
        row=view.row,
        recordings=view.recordings,
        calibrations=[row for row in rows if names & set(row.recording_ids["recordings"])],
        frames_a_pose=max([1, *exposures]),
    )


def guidance_told(shown: SessionShown, told: Mapping[str, Guidance]) -> dict[str, Any]:
    """Return what a session's script is told, sensor by sensor."""
    recordings = {each.sensor: each.id for each in shown.recordings}
    return {
        "state": shown.row.state.value,
        "pictures": shown.row.pictures,
        "sensors": [
            {
                **asdict(each),
                "sensor": sensor,
                "recording": recordings[sensor],
                "frames_a_pose": shown.frames_a_pose,
                "enough": each.enough,
                "criteria": [{**asdict(one), "met": one.met} for one in each.criteria],
            }
            for sensor, each in told.items()
        ],
    }
