"""Software triggers: a caller commands one, and is answered when its frames are in the file."""

import time
from dataclasses import dataclass

from station.capture.camera import Camera
from station.capture.control import Answer, refusal
from station.capture.session import CaptureSession
from station.capture.status import CaptureState
from station.errors import CameraError, StateConflict, StationError

_TIMEOUT_S = 2.0


@dataclass(frozen=True, slots=True)
class _Waiting:
    """Who waits for the frame just triggered, and what had come before it."""

    answer: Answer
    deadline_s: float
    recorded: int
    refused: int


class Triggering:
    """The triggers of one recording: each takes a group of frames, one after the other.

    The next frame of a group is triggered when the last is in the file, for the camera must be set
    anew in between.
    """

    def __init__(self, session: CaptureSession) -> None:
        self._session = session
        self._waiting: _Waiting | None = None

    @property
    def busy(self) -> bool:
        """Whether a group is being taken."""
        return self._waiting is not None

    def begin(self, camera: Camera, answer: Answer) -> None:
        """Take the first frame of a group; `step` goes on with it, and answers.

        Raises
        ------
        StateConflict
            If a group is being taken.
        CameraError
            If the camera does not take the trigger.
        """
        if self._waiting is not None:
            raise StateConflict(
                "a trigger is under way; wait for its frame", state=str(CaptureState.RECORDING)
            )
        self._session.wake(camera)
        self._session.sequencer.begin()
        self._fire(camera, answer)

    def step(self, camera: Camera | None) -> None:
        """See whether the frame has come, and go on with the group or answer."""
        waiting, intake = self._waiting, self._session.intake
        if waiting is None:
            return
        if intake.account.recorded > waiting.recorded:
            self._go_on(camera, waiting.answer)
        elif intake.failure is not None:
            self._refuse(intake.failure)
        elif intake.account.refused > waiting.refused:
            self._refuse(CameraError("the frame arrived incomplete; trigger again"))
        elif time.monotonic() > waiting.deadline_s and not intake.in_flight:
            self._refuse(CameraError("no frame came of the trigger; is the camera triggered?"))

    def end(self) -> None:
        """Tell who still waits that the recording is finished, unless their frame is in it."""
        # A recording ends when its last frame has arrived; it is written while the file is closed.
        self.step(None)
        self._refuse(CameraError("the recording was finished before the frame came"))

    def _fire(self, camera: Camera, answer: Answer) -> None:
        account = self._session.intake.account
        recorded, refused = account.recorded, account.refused
        self._session.sequencer.fire(camera)
        deadline_s = time.monotonic() + _TIMEOUT_S + camera.exposure_us * 1e-6
        self._waiting = _Waiting(answer, deadline_s, recorded, refused)

    def _go_on(self, camera: Camera | None, answer: Answer) -> None:
        if not self._session.sequencer.more:
            self._waiting = None
            answer({"frame_id": self._session.intake.last_recorded_id})
        elif camera is None:
            self._refuse(CameraError("the camera was lost within a sequence; trigger again"))
        else:
            try:
                self._fire(camera, answer)
            except StationError as error:
                self._refuse(error)

    def _refuse(self, error: StationError) -> None:
        if self._waiting is not None:
            waiting, self._waiting = self._waiting, None
            waiting.answer(refusal(error))
