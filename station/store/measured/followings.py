"""What is kept of measuring while a train passes, until the finished recordings are measured.

A reading is given as soon as its wheel seems over. Where a later frame shows that it was not, the
reading is withdrawn and the right one stands in its place. What is kept here of a finished pass is
of recordings that could not be measured to their end.
"""

from collections.abc import Iterable, Sequence
from itertools import takewhile

from sqlalchemy import delete, select
from sqlalchemy.orm import Session

from station.store.measured.measurements import add_measurements
from station.store.tables import EarlyReading, Following, Measurement, MeasurementProfile

_PROFILE = "profile"
_SAME = (
    "recording_id",
    "frame",
    "calibration_id",
    "rig_calibration_id",
    "sensor",
    "reference",
    "regime",
    "software",
)


def followings_of(session: Session, recordings: Iterable[str]) -> Sequence[Following]:
    """Return how far recordings have been followed; none of one that was not, or has ended."""
    wanted = select(Following).where(Following.recording_id.in_(sorted(recordings)))
    return session.scalars(wanted.order_by(Following.recording_id)).all()


def keep_followed(
    session: Session,
    recordings: Iterable[str],
    certain: Sequence[Measurement],
    early: Sequence[Measurement] = (),
) -> int:
    """Keep the next wheels of what is followed; return how many early readings were withdrawn.

    Parameters
    ----------
    recordings
        By id, those that are measured together.
    certain
        The wheels over since the last call, in order.
    early
        Those that may still go on, as they are by now; none that was kept before and is not named
        here stays.
    """
    present = _early_of(session, recordings)
    wanted = [*certain, *early]
    pairs = zip(present, wanted, strict=False)
    same = len(list(takewhile(lambda pair: _alike(*pair), pairs)))
    if present:
        _unmark(session, present[:same])
        _withdraw(session, present[same:])
    add_measurements(session, wanted[same:])
    session.flush()
    _mark(session, [*present[:same], *wanted[same:]][len(certain) :])
    return len(present) - same


def note_followed(session: Session, followings: Iterable[Following]) -> None:
    """Note how far recordings have been followed, in place of what was noted before."""
    for following in followings:
        session.merge(following)


def end_following(session: Session, recordings: Iterable[str]) -> None:
    """Forget how far recordings were followed; the readings they have are no longer early."""
    own = sorted(recordings)
    _unmark(session, _early_of(session, own))
    session.execute(delete(Following).where(Following.recording_id.in_(own)))


def forget_followed(session: Session, recordings: Iterable[str]) -> int:
    """Withdraw every reading made of recordings while they were written; return how many."""
    wanted = (
        select(Measurement)
        .join(Following, Following.recording_id == Measurement.recording_id)
        .where(Measurement.recording_id.in_(sorted(recordings)))
    )
    rows = session.scalars(wanted).all()
    _withdraw(session, rows)
    end_following(session, recordings)
    return len(rows)


def _early_of(session: Session, recordings: Iterable[str]) -> Sequence[Measurement]:
    return session.scalars(
        select(Measurement)
        .join(EarlyReading, EarlyReading.measurement_id == Measurement.id)
        .where(Measurement.recording_id.in_(sorted(recordings)))
        .order_by(Measurement.id)
    ).all()


def _alike(present: Measurement, wanted: Measurement) -> bool:
    """Tell whether two rows say the same; when they were made is another matter."""
    # The profile is not compared: frames and readings agree to the last bit, so it does too.
    said = {name: value for name, value in wanted.wheel.items() if name != _PROFILE}
    same = all(getattr(present, name) == getattr(wanted, name) for name in _SAME)
    return same and present.wheel == said


def _withdraw(session: Session, rows: Sequence[Measurement]) -> None:
    _unmark(session, rows)
    ids = [row.id for row in rows]
    profiles = MeasurementProfile.measurement_id.in_(ids)
    session.execute(delete(MeasurementProfile).where(profiles))
    session.execute(delete(Measurement).where(Measurement.id.in_(ids)))


def _unmark(session: Session, rows: Iterable[Measurement]) -> None:
    marks = EarlyReading.measurement_id.in_([row.id for row in rows])
    session.execute(delete(EarlyReading).where(marks))


def _mark(session: Session, rows: Iterable[Measurement]) -> None:
    # One that was not added has no id: its frame is another measurement's already.
    session.add_all(EarlyReading(measurement_id=row.id) for row in rows if row.id is not None)
