"""Guiding sessions, drawing reports, telling shifts: by the names of things, never by a path.

Nothing is found or solved here: the guiding process does that.
"""

from collections.abc import Mapping

from sqlalchemy.orm import Session

from calib import Target
from measure import ReadingShifts
from station.documents import CalibrationDocument
from station.errors import StateConflict
from station.guiding import Demands, Guidance, Guide, SessionWatch
from station.operations.collaborators import Station
from station.operations.shifts import CalibrationShifts, shifts_to_tell
from station.store import (
    Calibration,
    CalibrationPoints,
    CalibrationSession,
    Recording,
    active,
    recordings_of,
    the,
)

_NO_WHEEL = "no wheel that shows its flange back has been measured yet"


class Guiding:
    """The desk that guides."""

    def __init__(self, station: Station, guide: Guide) -> None:
        self._station = station
        self._guide = guide

    def guidance(self, session_id: str) -> Mapping[str, Guidance]:
        """Return what to tell of a session by now, by its sensors.

        Raises
        ------
        NotFound
            If there is no such session.
        RecordingUnreadable
            If a picture is damaged.
        GuideLost
            If the guiding process gives no answer.
        """
        with self._station.store.look() as session:
            row = the(session, CalibrationSession, session_id)
            asked = {
                each.sensor: (self._watch(row, each), self._present(session, each.sensor))
                for each in recordings_of(session, row)
            }
        demands = Demands(self._station.settings.recalibration.gates.fewest_poses)
        return {
            sensor: self._guide.guidance(watch, demands, present)
            for sensor, (watch, present) in asked.items()
        }

    def report(self, calibration_id: str) -> str:
        """Return the printable report of a calibration as a whole HTML page.

        Raises
        ------
        NotFound
            If there is no such calibration.
        StateConflict
            If it is not ready.
        GuideLost
            If the guiding process gives no answer.
        """
        with self._station.store.look() as session:
            row = the(session, Calibration, calibration_id)
            points = session.get(CalibrationPoints, calibration_id)
            if row.document is None or points is None:
                raise StateConflict(
                    f"calibration {calibration_id} is {row.state}; only a ready one has a report",
                    state=row.state,
                )
            used = [
                session.get(Recording, name) for name in row.recording_ids.get("recordings", [])
            ]
        # What was deleted since has no pictures any more; all else of the report stays.
        sources = [
            self._station.layout.root / each.path
            for each in used
            if each is not None and each.deleted_at is None
        ]
        document = CalibrationDocument.model_validate_json(row.document)
        return self._guide.report(document, points.csv, sources)

    def shifts(self, calibration_id: str) -> CalibrationShifts | None:
        """Return by how much readings shift with a calibration; None where it has no rival.

        They are told on the last wheel that its sensor, or its sensor's rig, has measured.

        Raises
        ------
        NotFound
            If there is no such calibration.
        StateConflict
            If it is not ready.
        GuideLost
            If the guiding process gives no answer.
        """
        with self._station.store.look() as session:
            asked = shifts_to_tell(session, self._station.settings, calibration_id)
        if asked is None:
            return None
        if asked.seen is None:
            return asked.told(ReadingShifts((), _NO_WHEEL))
        return asked.told(self._guide.shifts(asked.new, asked.seen))

    def _watch(self, row: CalibrationSession, recording: Recording) -> SessionWatch:
        settings = self._station.settings.sensor(recording.sensor)
        target = (row.targets or {}).get(recording.sensor, row.target)
        return SessionWatch(
            self._station.layout.root / recording.path,
            Target.parse(target),
            () if settings is None else settings.calibration_exposures,
        )

    @staticmethod
    def _present(session: Session, sensor: str) -> CalibrationDocument | None:
        activation = active(session, sensor)
        if activation is None:
            return None
        document = the(session, Calibration, activation.calibration_id).document
        return None if document is None else CalibrationDocument.model_validate_json(document)
