"""The settings that Aravis itself knows of every camera, whatever their makers call them.

Each is compared with what the camera takes before it is written, and read back after: a camera may
round a value, or take it and ignore it.  Features that go by their names alone are `Features`.
"""

from collections.abc import Callable
from typing import Any

from station.capture.features import same
from station.capture.packet_size import PacketSize, fitting
from station.capture.plan import Trigger
from station.errors import CameraRefused

_TRIGGER_SOURCES = {Trigger.SOFTWARE: "Software", Trigger.LINE1: "Line1"}
_GAIN_STEP_DB = 0.4
"""The coarsest steps of analogue gain."""


class CommonSettings:
    """Exposure, gain, frame rate, packets and trigger of one camera.

    Every method raises CameraRefused where the camera does not take the value, and may raise
    GLib.Error.
    """

    def __init__(self, camera: Any, address: str) -> None:
        self._camera = camera
        self._address = address

    def set_exposure(self, exposure_us: float) -> None:
        """Set the exposure time."""
        camera = self._camera
        self._check("exposure", exposure_us, "us", camera.get_exposure_time_bounds())
        camera.set_exposure_time(exposure_us)
        self._compare("exposure", exposure_us, "us", camera.get_exposure_time())

    def set_gain(self, gain_db: float) -> None:
        """Set the gain."""
        camera = self._camera
        self._check("gain", gain_db, "dB", camera.get_gain_bounds())
        camera.set_gain(gain_db)
        self._compare("gain", gain_db, "dB", camera.get_gain(), _GAIN_STEP_DB)

    def set_trigger(self, trigger: Trigger, frame_rate_hz: float) -> None:
        """Set what a frame is taken at, and how many a second there may be."""
        # The frame rate first: setting it clears the triggers.
        self._camera.clear_triggers()
        self._set_frame_rate(frame_rate_hz)
        if trigger is Trigger.FREE:
            return
        source = _TRIGGER_SOURCES[trigger]
        offered = list(self._camera.dup_available_trigger_sources())
        if source not in offered:
            raise CameraRefused(
                f"trigger = {trigger} is asked of camera {self._address}; it takes "
                f"{', '.join(offered) or 'none'}: change the sensor's settings"
            )
        self._camera.set_trigger(source)

    def set_packet_delay(self, delay_ns: int) -> None:
        """Set the pause between packets."""
        self._camera.gv_set_packet_delay(delay_ns)
        self._compare("packet_delay_ns", delay_ns, "ns", self._camera.gv_get_packet_delay())

    def set_packet_size(self, asked: int, carries: Callable[[int], bool]) -> PacketSize:
        """Set the largest usual packet size up to the one asked that the way carries."""
        # Not Aravis' "auto": it takes packets that the path does not carry.
        size = fitting(asked, carries)
        self._camera.gv_set_packet_size(size.used)
        found = self._camera.gv_get_packet_size()
        if found != size.used:
            raise CameraRefused(
                f"packet_size = {size.used} is asked of camera {self._address}; it holds "
                f"{found} after it was set: change the sensor's settings"
            )
        return size

    def _set_frame_rate(self, rate_hz: float) -> None:
        camera = self._camera
        self._check("frame rate", rate_hz, "Hz", camera.get_frame_rate_bounds())
        camera.set_frame_rate(rate_hz)
        self._compare("frame rate", rate_hz, "Hz", camera.get_frame_rate())

    def _check(self, name: str, value: float, unit: str, bounds: tuple[float, float]) -> None:
        low, high = bounds
        if not (low <= value <= high):
            raise CameraRefused(
                f"{name} {value:g} {unit} is asked of camera {self._address}; "
                f"it takes {low:g} to {high:g} {unit}: change the sensor's settings"
            )

    def _compare(
        self, name: str, wanted: float, unit: str, found: float, step: float = 0.0
    ) -> None:
        """Compare with what was read back."""
        if not same(float(found), wanted, step):
            raise CameraRefused(
                f"{name} {wanted:g} {unit} is asked of camera {self._address}; it holds "
                f"{found:g} {unit} after it was set: change the sensor's settings"
            )
