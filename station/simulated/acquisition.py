"""When the simulated camera exposes: free run or triggers, counted and timed."""

import math
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from calib import Picture
from station.simulated import registers as reg
from station.simulated.gvsp import Region, next_block_id
from station.simulated.memory import CameraMemory
from station.simulated.playback import Playback, Shot

MAX_WAITING_TRIGGERS = 256


@dataclass(frozen=True, slots=True)
class ExposureSettings:
    """What the registers say of the next exposure.

    `frames` is None where the acquisition goes on until it is stopped, `trigger` is None in
    free run; `gained_exposure_us` is the exposure time times the gain. The exposure follows its
    trigger by `delay_s`; edges of a line within `debounce_s` of the last are none. `laser` is the
    level of the user output, `black_level` is added to every pixel.
    """

    region: Region
    frames: int | None
    trigger: reg.TriggerSource | None
    period_s: float
    exposure_us: float
    gained_exposure_us: float
    delay_s: float = 0.0
    debounce_s: float = 0.0
    laser: bool = True
    black_level: float = 0.0

    @classmethod
    def of(cls, memory: CameraMemory, own_frame_rate_hz: float) -> "ExposureSettings":
        """Read the settings from the registers."""
        exposure_us = memory.get_real(reg.EXPOSURE_TIME)
        enabled = memory.get(reg.FRAME_RATE_ENABLE)
        rate_hz = memory.get_real(reg.FRAME_RATE) if enabled else own_frame_rate_hz
        triggered = memory.get(reg.TRIGGER_MODE)
        frames = {
            reg.AcquisitionMode.CONTINUOUS: None,
            reg.AcquisitionMode.SINGLE_FRAME: 1,
            reg.AcquisitionMode.MULTI_FRAME: memory.get(reg.ACQUISITION_FRAME_COUNT),
        }
        return cls(
            region=memory.region,
            frames=frames[reg.AcquisitionMode(memory.get(reg.ACQUISITION_MODE))],
            trigger=reg.TriggerSource(memory.get(reg.TRIGGER_SOURCE)) if triggered else None,
            period_s=max(1.0 / rate_hz, exposure_us * 1e-6),
            exposure_us=exposure_us,
            gained_exposure_us=exposure_us * 10.0 ** (memory.get_real(reg.GAIN) / 20.0),
            delay_s=memory.get_real(reg.TRIGGER_DELAY) * 1e-6 if triggered else 0.0,
            debounce_s=memory.get_real(reg.LINE_DEBOUNCER) * 1e-6,
            laser=bool(memory.get(reg.USER_OUTPUT)),
            black_level=memory.get_real(reg.BLACK_LEVEL),
        )


@dataclass(frozen=True, slots=True)
class Exposure:
    """One exposure.

    Attributes
    ----------
    index
        Exposures since the device started, from 0.
    block_id
        Its number in this acquisition, as GVSP counts.
    timestamp_ns
        When it began, UTC: the trigger's own time, or the scheduled one in free run.
    ready_s
        When it ends, on the monotonic clock.
    acquisition
        Number of the acquisition it belongs to.
    picture
        What it shows, where the source plays pictures with times of their own.
    """

    index: int
    block_id: int
    timestamp_ns: int
    ready_s: float
    acquisition: int
    settings: ExposureSettings
    picture: Picture | None = None


class Acquisition:
    """Hands out exposures while an acquisition runs.

    The thread of the sensor waits in `next_exposure`; commands and triggers come from others.
    """

    def __init__(
        self,
        settings: Callable[[], ExposureSettings],
        *,
        first_block_id: int = 1,
        playback: Playback | None = None,
        monotonic_s: Callable[[], float] = time.monotonic,
        utc_ns: Callable[[], int] = time.time_ns,
    ) -> None:
        self._settings = settings
        self._first_block_id = first_block_id
        self._playback = playback  # used by who holds the lock
        self._monotonic_s = monotonic_s
        self._utc_ns = utc_ns
        self._changed = threading.Condition()
        self._running = False
        self._closed = False
        self._number = 0
        self._index = 0
        self._missed_triggers = 0
        self._block_id = first_block_id
        self._frames_left: int | None = None
        self._due_s = 0.0
        self._begun_s, self._begun_ns = 0.0, 0
        self._triggers: deque[tuple[int, float]] = deque()
        self._edge_s = -math.inf

    @property
    def running(self) -> bool:
        return self._running

    @property
    def exposed(self) -> int:
        """Exposures since the device started."""
        return self._index

    @property
    def missed_triggers(self) -> int:
        """Triggers that came while the camera did not wait for them."""
        return self._missed_triggers

    @property
    def played_out(self) -> bool:
        """A playback has come to its end, and whoever received it has stopped."""
        with self._changed:
            return self._ended and not self._running and self._number > 0

    @property
    def number(self) -> int:
        """Number of the present or last acquisition, 0 before the first."""
        return self._number

    def start(self) -> None:
        """Begin an acquisition; block ids begin anew."""
        with self._changed:
            if self._running:
                return
            self._running = True
            self._number += 1
            self._block_id = self._first_block_id
            self._frames_left = self._settings().frames
            if self._playback is not None:
                self._playback.rewind()
            self._begun_s, self._begun_ns = self._monotonic_s(), self._utc_ns()
            self._due_s = self._begun_s
            self._triggers.clear()
            self._changed.notify_all()

    def stop(self) -> None:
        """End the acquisition; nothing more is exposed."""
        with self._changed:
            self._running = False
            self._triggers.clear()
            self._changed.notify_all()

    def close(self) -> None:
        """Let `next_exposure` return None from now on."""
        with self._changed:
            self._closed = True
            self._running = False
            self._changed.notify_all()

    def settings_changed(self) -> None:
        """Let a waiting `next_exposure` look at the settings again."""
        with self._changed:
            self._changed.notify_all()

    def trigger(self, source: reg.TriggerSource, timestamp_ns: int | None = None) -> bool:
        """Ask for an exposure; return whether the camera takes it."""
        with self._changed:
            settings = self._settings()
            waiting = settings.trigger is source and not (self._plays(settings) or self._ended)
            if source is reg.TriggerSource.LINE1 and self._bounces(settings.debounce_s):
                return False
            if not (self._running and waiting and len(self._triggers) < MAX_WAITING_TRIGGERS):
                self._missed_triggers += 1
                return False
            begun_ns = self._utc_ns() if timestamp_ns is None else timestamp_ns
            self._triggers.append((begun_ns, self._monotonic_s()))
            self._changed.notify_all()
            return True

    def _bounces(self, debounce_s: float) -> bool:
        """Return whether the edge that just came is the echo of the one before."""
        before_s, self._edge_s = self._edge_s, self._monotonic_s()
        return self._edge_s - before_s < debounce_s

    def next_exposure(self) -> Exposure | None:
        """Wait for the next exposure and return it, or None once closed."""
        with self._changed:
            while not self._closed:
                wait_s = None
                if self._running:
                    settings = self._settings()
                    if self._triggers and not self._ended:
                        return self._expose(*self._triggers.popleft(), settings)
                    due_s = self._next_due(settings)
                    if due_s is not None:
                        now_s = self._monotonic_s()
                        wait_s = due_s - now_s
                        if wait_s <= 0.0:
                            return self._expose_on_schedule(now_s, settings)
                self._changed.wait(wait_s)
            return None

    @property
    def _ended(self) -> bool:
        return self._playback is not None and self._playback.upcoming() is None

    def _plays(self, settings: ExposureSettings) -> bool:
        """Return whether the playback says when exposures are; software triggers overrule it."""
        return self._playback is not None and settings.trigger is not reg.TriggerSource.SOFTWARE

    def _next_due(self, settings: ExposureSettings) -> float | None:
        """Return when the next exposure is that nobody triggers, on the monotonic clock."""
        if self._playback is not None and self._plays(settings):
            shot = self._playback.upcoming()
            return None if shot is None else self._begun_s + shot.after_ns * 1e-9
        return self._due_s if settings.trigger is None else None

    def _expose_on_schedule(self, now_s: float, settings: ExposureSettings) -> Exposure:
        shot = None if self._playback is None else self._playback.upcoming()
        if shot is not None:
            # Late as it may be, its time is that of the recording to the nanosecond.
            begun_s = self._begun_s + shot.after_ns * 1e-9
            return self._expose(self._begun_ns + shot.after_ns, begun_s, settings)
        begun_s = self._due_s
        # A source slower than the frame rate sets the pace; nothing is caught up afterwards.
        self._due_s = max(begun_s + settings.period_s, now_s)
        begun_ns = self._utc_ns() - round((now_s - begun_s) * 1e9)
        return self._expose(begun_ns, begun_s, settings)

    def _expose(self, begun_ns: int, begun_s: float, settings: ExposureSettings) -> Exposure:
        shot = self._next_shot()
        exposure = Exposure(
            index=self._index,
            block_id=self._block_id if shot is None else shot.block_id,
            timestamp_ns=begun_ns + round(settings.delay_s * 1e9),
            ready_s=begun_s + settings.delay_s + settings.exposure_us * 1e-6,
            acquisition=self._number,
            settings=settings,
            picture=None if shot is None else shot.picture,
        )
        self._index += 1
        self._block_id = next_block_id(self._block_id)
        if self._frames_left is not None:
            self._frames_left -= 1
            self._running = self._frames_left > 0
        return exposure

    def _next_shot(self) -> Shot | None:
        if self._playback is None:
            return None
        shot = self._playback.upcoming()
        self._playback.take()
        return shot
