"""Showing what the sensors see and saw: the newest frame, a look, any frame of a recording.

Nothing is drawn here: the viewing process makes what is asked for.
"""

from collections.abc import Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from sqlalchemy import or_, select

from station.errors import InputUnusable, NotFound, RecordingUnreadable
from station.operations.collaborators import Station
from station.operations.downloads import recording_files
from station.operations.sensors import sensor_at
from station.recording import left_behind
from station.store import Recording
from station.viewing import Form, SharedPicture, View, Viewer, ViewOrder

_CANDIDATES = 2
"""The recording being made, in which there may be no frame yet, and the last one with frames."""


@dataclass(frozen=True, slots=True)
class Shown:
    """A frame as it was asked for."""

    recording: str | None
    """The recording it is in; None of a look."""
    view: View


class Showing:
    """Shows frames, by the names of sensors and recordings and never by a path."""

    def __init__(self, station: Station, viewer: Viewer) -> None:
        self._station = station
        self._viewer = viewer

    def newest(
        self, sensor: str, form: Form, *, max_width: int | None, known: tuple[str, int] | None
    ) -> Shown | None:
        """Return the newest frame of the recording being made, or of the last one that has any.

        None where that is the frame that the caller has: `known`, a recording and a number.

        Raises
        ------
        NotFound
            If there is no such sensor, or it has recorded nothing.
        RecordingUnreadable
            If the frame is damaged.
        ViewerLost
            If it cannot be made.
        """
        sensor_at(self._station.settings, sensor)
        for row in self._candidates(sensor):
            number = known[1] if known is not None and known[0] == row.id else None
            if number is not None and row.closed_at is not None and number == row.recorded:
                return None  # no process is asked while nothing is recorded
            try:
                view = self._newest_of(row, form, max_width, number)
            except NotFound:
                continue
            return None if view is None else Shown(row.id, view)
        raise NotFound(f"sensor {sensor} has recorded no frame that is still there")

    def frame(self, recording_id: str, number: int, form: Form, *, max_width: int | None) -> Shown:
        """Return the frame of that number, from 1, of a closed recording.

        Raises
        ------
        NotFound
            If there is no such recording, or it has no such frame.
        StateConflict
            If it is still being written, or was deleted.
        RecordingUnreadable, ViewerLost
            As of `newest`.
        """
        row = self._closed(recording_id)
        order = ViewOrder(
            form,
            self._path(row),
            number=number,
            max_width=max_width,
            about={"sensor": row.sensor, "recording": row.id},
        )
        view = self._ask(order, row)
        if view is None:
            raise NotFound(f"recording {recording_id} has no frame {number}")
        return Shown(row.id, view)

    def timeline(self, recording_id: str, frame_ids: Sequence[int] = ()) -> Shown:
        """Return how the frames and events of a closed recording lie in time.

        Parameters
        ----------
        recording_id
            Which.
        frame_ids
            Frames whose places are wanted, as the camera numbers them.

        Raises
        ------
        NotFound
            If there is no such recording, or no frame in it.
        StateConflict, RecordingUnreadable, ViewerLost
            As of `frame`.
        """
        row = self._closed(recording_id)
        order = ViewOrder(
            Form.TIMELINE,
            self._path(row),
            about={"sensor": row.sensor, "recording": row.id},
            frame_ids=tuple(frame_ids),
        )
        view = self._ask(order, row)
        if view is None:
            raise NotFound(f"recording {recording_id} has no frame")
        return Shown(row.id, view)

    def look(self, sensor: str, form: Form, *, max_width: int | None) -> Shown:
        """Have a camera take a picture now, which is recorded nowhere; return it.

        Raises
        ------
        NotFound
            If there is no such sensor.
        StateConflict
            If it is neither idle nor in a calibration session, between two of its pictures.
        CameraError
            If no whole picture comes.
        ViewerLost
            As of `newest`.
        """
        sensor_at(self._station.settings, sensor)
        with self._station.captures[sensor].look() as seen:
            shared = SharedPicture(seen.descriptor, seen.width, seen.height, seen.received_ns)
            about = {"sensor": sensor, "recording": None}
            order = ViewOrder(form, shared=shared, max_width=max_width, about=about)
            view = self._viewer.view(order)
        if view is None:
            raise NotFound(f"sensor {sensor}: nothing was seen")
        return Shown(None, view)

    def _closed(self, recording_id: str) -> Recording:
        """Return a recording that is closed and on the disk."""
        if not recording_files(self._station, recording_id):
            raise NotFound(f"recording {recording_id} has no file on the disk")
        with self._station.store.look() as session:
            return session.get_one(Recording, recording_id)

    def _newest_of(
        self, row: Recording, form: Form, max_width: int | None, known: int | None
    ) -> View | None:
        order = ViewOrder(
            form,
            self._path(row),
            growing=row.closed_at is None,
            known=known,
            max_width=max_width,
            about={"sensor": row.sensor, "recording": row.id},
        )
        return self._ask(order, row)

    def _candidates(self, sensor: str) -> Sequence[Recording]:
        """Return the recordings that may have a sensor's newest frame, the newest first."""
        query = (
            select(Recording)
            .where(Recording.sensor == sensor)
            .where(Recording.sha256.is_(None))  # no upload: when its frames were taken, who knows
            .where(Recording.deleted_at.is_(None))
            .where(or_(Recording.closed_at.is_(None), Recording.recorded > 0))
            .order_by(Recording.opened_at.desc(), Recording.id.desc())
            .limit(_CANDIDATES)
        )
        with self._station.store.look() as session:
            return session.scalars(query).all()

    def _path(self, row: Recording) -> Path:
        return self._station.layout.root / row.path

    def _ask(self, order: ViewOrder, row: Recording) -> View | None:
        with _without_paths(self._path(row), row.id):
            return self._viewer.view(order)


@contextmanager
def _without_paths(path: Path, recording_id: str) -> Generator[None]:
    """Name a file of a recording by its number: where the station keeps it is nobody's business."""
    try:
        yield
    except (InputUnusable, RecordingUnreadable) as error:
        said = str(error)
        for number, part in left_behind(path):
            said = said.replace(str(part), f"file {number} of recording {recording_id}")
        raise type(error)(said.replace(str(path.parent), "")) from error
