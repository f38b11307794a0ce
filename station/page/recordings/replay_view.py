"""A replay of a recording: how far it is, and its readings beside those that were there."""

from dataclasses import dataclass

from sqlalchemy.orm import Session

from station.errors import NotFound
from station.operations import Station
from station.page.recordings.comparison import Compared, compared, profiles_compared
from station.page.recordings.wheels import own_readings
from station.store import JOB, Calibration, Job, JsonObject, Measurement, Recording, Replay, the
from station.store.measured import profiles_of
from station.store.recordings_found import measured_from, measured_together_with, replayed_as


@dataclass(frozen=True, slots=True)
class ReplayPage:
    """What the page of a replay shows of one recording."""

    recording: Recording
    row: Replay
    job: Job
    before: Calibration | None
    """What the recording had been measured with; None where it had not been measured."""
    after: Calibration
    before_reference: str | None
    before_rig: str | None
    """The rig's calibration, where it had been measured together with others."""
    together: tuple[str, ...]
    """The recordings that it was measured together with now."""
    wheels: tuple[Compared, ...]
    refused: str | None
    """Why the recording could not be measured."""

    @property
    def ended(self) -> bool:
        """Whether nothing more comes of it."""
        return JOB.ended(self.job.state)

    @property
    def comparable(self) -> int:
        """Quantities of all wheels that can be compared."""
        return sum(each.agrees is not None for pair in self.wheels for each in pair.differences)

    @property
    def agreeing(self) -> int:
        """How many of them agree."""
        return sum(each.agrees is True for pair in self.wheels for each in pair.differences)


def replay_page(station: Station, recording_id: str, replay_id: str) -> ReplayPage:
    """Return a replay as it stands, as far as it is of a recording.

    Raises
    ------
    NotFound
        If there is no such recording or replay, or the replay is not of the recording.
    """
    with station.store.look() as session:
        recording = the(session, Recording, recording_id)
        row = the(session, Replay, replay_id)
        step = _step_of(row, recording_id)
        # A rig's wheels are kept with the frames of whichever of its sensors saw them best.
        after = [each for each in replayed_as(session, row.id) if each.recording_id in step]
        before = _measured_before(session, recording, after)
        return ReplayPage(
            recording=recording,
            row=row,
            job=the(session, Job, row.job_id),
            before=the(session, Calibration, before[0].calibration_id) if before else None,
            after=the(session, Calibration, row.calibrations[recording.sensor]),
            before_reference=before[0].reference if before else None,
            before_rig=before[0].rig_calibration_id if before else None,
            together=tuple(each for each in step if each != recording.id),
            wheels=compared(before, after),
            refused=row.results.get(step[0], {}).get("refused"),
        )


def compared_profiles(station: Station, before: int | None, after: int | None) -> JsonObject:
    """Return the profiles of two measurements on one grid; empty where there is no point.

    Raises
    ------
    NotFound
        If there is no such measurement.
    """
    with station.store.look() as session:
        wanted = [
            None if each is None else the(session, Measurement, each) for each in (before, after)
        ]
        found = profiles_of(session, [each for each in wanted if each is not None])
    first, second = (None if each is None else found.get(each.id) for each in wanted)
    return profiles_compared(first, second) or {}


def _step_of(row: Replay, recording_id: str) -> list[str]:
    """Return the recordings that were measured together with one; NotFound where none was."""
    for step in row.steps["steps"]:
        if recording_id in step:
            return list(step)
    raise NotFound(f"replay {row.id} is not of recording {recording_id}")


def _measured_before(
    session: Session, recording: Recording, after: list[Measurement]
) -> list[Measurement]:
    """Return what a replay is compared with: the recording's own readings, also its rig's."""
    known = {each.id for each in after}
    own, together = (
        [each for each in found if each.id not in known]
        for found in (
            measured_from(session, recording.id),
            measured_together_with(session, recording),
        )
    )
    return own_readings(recording, own, together)
