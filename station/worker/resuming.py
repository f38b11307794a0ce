"""Where measuring goes on with what was measured while the train still passed."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import structlog
from sqlalchemy.orm import Session

from station.errors import RecordingError
from station.limits import limits_of
from station.pipeline import Resumption, load_reference
from station.recording import FilePlace, has_place
from station.software import SOFTWARE
from station.store import Following, Measurement, Recording
from station.store.measured import (
    add_measurements,
    end_following,
    followings_of,
    forget_followed,
    keep_followed,
)
from station.worker.context import WorkContext

_log = structlog.get_logger()


@dataclass(frozen=True, slots=True)
class Means:
    """What wheels are measured with, beside the calibration that a recording names."""

    reference: str
    regime: str
    software: str

    @classmethod
    def of(cls, context: WorkContext) -> "Means":
        """Return those of this worker.

        Raises
        ------
        InputUnusable
            If the reference of the settings cannot be used.
        """
        settings = context.settings
        return cls(
            reference=load_reference(settings.reference).name,
            regime=limits_of(settings.limits).regime,
            software=SOFTWARE,
        )

    def were_those_of(self, following: Following) -> bool:
        """Tell whether a recording was followed with the same."""
        said = following.reference, following.regime, following.software
        return said == (self.reference, self.regime, self.software)


def noted(session: Session, means: Means, recordings: Iterable[Recording]) -> Resumption | None:
    """Return where measuring these together goes on; None where it begins at the beginning.

    It does where one of them was not followed, or with other means.
    """
    sensors = {each.id: each.sensor for each in recordings}
    rows = followings_of(session, sensors)
    if len(rows) < len(sensors) or not all(map(means.were_those_of, rows)):
        return None
    places = {
        sensors[row.recording_id]: FilePlace(row.part, row.offset_bytes, row.frames) for row in rows
    }
    return Resumption(places, any(row.shown_before for row in rows))


def to_note(
    means: Means, recordings: Mapping[str, Recording], resumption: Resumption
) -> list[Following]:
    """Return the rows that keep where measuring goes on, of recordings by sensor."""
    rows = []
    for sensor, recording in recordings.items():
        place = resumption.of(sensor)
        rows.append(
            Following(
                recording_id=recording.id,
                reference=means.reference,
                regime=means.regime,
                software=means.software,
                part=place.part,
                offset_bytes=place.offset_bytes,
                frames=place.frames,
                shown_before=resumption.shown_before,
            )
        )
    return rows


@dataclass(frozen=True, slots=True)
class Measured:
    """Wheels of finished recordings: all, or those that were not certain while they were written.

    Attributes
    ----------
    recordings
        By id, those that were measured together, also where one of them had nothing to measure.
    rows
        In the order of passing.
    since
        Whether wheels before them were kept already.
    """

    recordings: tuple[str, ...]
    rows: Sequence[Measurement]
    since: bool

    def keep(self, session: Session) -> None:
        """Keep them beside, or in place of, what was kept before; a second time adds nothing."""
        if self.since:
            keep_followed(session, self.recordings, self.rows)
            end_following(session, self.recordings)
        else:
            forget_followed(session, self.recordings)
            add_measurements(session, self.rows)


def measured_with_followed(
    context: WorkContext,
    recordings: Sequence[Recording],
    measurable: Sequence[Recording],
    measure: Callable[[Resumption | None], Sequence[Measurement]],
) -> Measured:
    """Measure what is left of finished recordings; all of it where that is not known for sure.

    Parameters
    ----------
    recordings
        All that are measured together.
    measurable
        Those of them that hold frames and have a calibration.
    measure
        Measures from a place on.

    Raises
    ------
    StationError
        If they cannot be measured.
    """
    ids = tuple(each.id for each in recordings)
    since = _since(context, recordings, measurable)
    if since is not None:
        try:
            return Measured(ids, measure(since), since=True)
        except RecordingError as error:
            # What was measured as they grew may rest on the part that is damaged.
            _log.warning("measured from the beginning", recordings=ids, why=str(error))
    return Measured(ids, measure(None), since=False)


def _since(
    context: WorkContext, recordings: Sequence[Recording], measurable: Sequence[Recording]
) -> Resumption | None:
    with context.store.look() as session:
        followed = {row.recording_id for row in followings_of(session, [r.id for r in recordings])}
        if not followed or followed != {each.id for each in measurable}:
            return None
        since = noted(session, Means.of(context), measurable)
    there = since is not None and all(
        has_place(context.layout.root / each.path, since.of(each.sensor)) for each in measurable
    )
    return since if there else None
