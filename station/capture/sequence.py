"""Software triggers: one frame each, or one of every step of an exposure sequence."""

from collections import deque
from collections.abc import Mapping
from typing import Protocol

from station.capture.plan import ExposureStep


class Exposing(Protocol):
    """What a camera does here."""

    def trigger(self) -> None: ...

    def expose_as(self, step: ExposureStep) -> ExposureStep: ...


class Sequencer:
    """Carries out a sequence at each command, a frame at a time, and knows which frame was which.

    A frame is told by its id: the camera numbers from 1 what it takes since it was started, and
    takes one frame a trigger.
    """

    def __init__(self, steps: tuple[ExposureStep, ...]) -> None:
        self.triggered = 0
        """Frames commanded."""
        self._steps = steps
        self._left: deque[int] = deque()
        self._since_start = 0
        self._group = 0
        self._how: dict[int, dict[str, float]] = {}

    @property
    def more(self) -> bool:
        """Whether the group lacks frames."""
        return bool(self._left)

    def begin(self) -> None:
        """Begin a group; what lacks of the last one is given up."""
        self._group += 1
        self._left = deque(range(max(1, len(self._steps))))

    def fire(self, camera: Exposing) -> None:
        """Take the group's next frame; raises what the camera does."""
        place = self._left[0]
        made = camera.expose_as(self._steps[place]) if self._steps else None
        camera.trigger()
        self._left.popleft()
        self.triggered += 1
        self._since_start += 1
        if made is not None:
            self._how[self._since_start] = self._values(made, place)

    def camera_started(self) -> None:
        """Note that the camera numbers from 1 again."""
        self._since_start = 0
        self._how.clear()

    def values_of(self, frame_id: int) -> Mapping[str, float] | None:
        """Return how a frame was taken; None where it belongs to no sequence."""
        return self._how.pop(frame_id, None)

    def _values(self, made: ExposureStep, place: int) -> dict[str, float]:
        return {
            "exposure_us": made.exposure_us,
            "gain_db": made.gain_db or 0.0,
            "laser": made.laser,
            "group": self._group,
            "step": place,
        }
