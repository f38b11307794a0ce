"""Seeing the target in the pictures of a session while they are taken."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from calib import Target, View
from station.pipeline import Exposure, Frame, observe_pose
from station.recording import BEGINNING, FilePlace, GrowingRecording, RecordedFrame
from station.settings import ExposureSettings


@dataclass(frozen=True, slots=True)
class SessionSoFar:
    """What one sensor has shown in a session.

    Attributes
    ----------
    seen
        Of each pose what was found, or why nothing was.
    size_px
        Width and height of the pictures; None before the first.
    next
        Where the recording goes on.
    """

    seen: tuple[View | str, ...] = ()
    size_px: tuple[int, int] | None = None
    next: FilePlace = BEGINNING

    @property
    def views(self) -> tuple[View, ...]:
        """The poses in which the target was found."""
        return tuple(each for each in self.seen if isinstance(each, View))


@dataclass(frozen=True, slots=True)
class SessionWatch:
    """What is to be looked for, and where.

    Attributes
    ----------
    recording
        First file of the sensor's recording, by the name it has once it is finished.
    target
        What its pictures show.
    exposures
        How the frames of each pose are exposed; none where each frame is a pose.
    """

    recording: Path
    target: Target
    exposures: tuple[ExposureSettings, ...] = ()

    def go_on(self, so_far: SessionSoFar) -> SessionSoFar:
        """Return what has been shown by now; frames of a pose that is not whole yet wait.

        Raises
        ------
        RecordingUnreadable
            If a frame is damaged.
        """
        growing = GrowingRecording(self.recording, so_far.next)
        try:
            while True:
                frames = growing.read(max(len(self.exposures), 1))
                if len(frames) < max(len(self.exposures), 1):
                    return so_far
                so_far = self._with(so_far, frames)
        finally:
            growing.close()

    def _with(
        self, so_far: SessionSoFar, frames: Sequence[tuple[FilePlace, RecordedFrame]]
    ) -> SessionSoFar:
        number = len(so_far.seen) + 1
        pose = tuple(self._frame(number, place, frame) for place, (_, frame) in enumerate(frames))
        height, width = pose[0].picture.shape
        last = frames[-1][0]
        return replace(
            so_far,
            seen=(*so_far.seen, observe_pose((pose, self.target, None))),
            size_px=(width, height),
            next=FilePlace(last.part, last.offset_bytes + 1, last.frames + 1),
        )

    def _frame(self, number: int, place: int, frame: RecordedFrame) -> Frame:
        name = f"pose {number}" if not self.exposures else f"pose {number}.{place + 1}"
        exposure = None
        if self.exposures:
            step = self.exposures[place]
            # The station takes the frames of a pose in the order of its settings.
            exposure = Exposure(step.exposure_us, step.gain_db or 0.0, step.laser, number)
        return Frame(
            name=name,
            source=self.recording.name,
            number=frame.frame_id,
            picture=frame.picture,
            exposure=exposure,
        )
