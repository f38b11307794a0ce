"""The camera through Aravis: opened, set up in the order that works, triggered, watched."""

import contextlib
from collections.abc import Generator, Iterable
from typing import Any

from station.capture.aravis import Aravis, GLib
from station.capture.burial import bury
from station.capture.open_stream import open_stream
from station.capture.ping import answers_ping
from station.capture.plan import Trigger
from station.capture.ring import Ring
from station.capture.stream import FrameStream
from station.errors import CameraError, CameraLost, CameraRefused, CameraUnreachable
from station.settings import SensorSettings

_PIXEL_FORMAT = "Mono8"


class Camera:
    """A camera under this process's control."""

    def __init__(self, settings: SensorSettings) -> None:
        """Open the camera and give it its settings.

        Raises
        ------
        CameraUnreachable
            If no camera answers at the address.
        CameraRefused
            If another host controls it, or it does not take a setting.
        """
        self._settings = settings
        address = settings.address
        if not answers_ping(address):
            raise CameraUnreachable(
                f"no camera answers at {address}; `station camera list` shows those in reach: "
                "check address, power and cable"
            )
        try:
            self._camera = Aravis.Camera.new(address)
        except GLib.Error as error:
            raise _unopened(address, error) from error
        self._device = self._camera.get_device()
        if not self.in_control():
            raise CameraRefused(
                f"camera {address} is controlled by another program; end that first"
            )
        with self._talking():
            self._set_up()
            *_, self.width, self.height = self._camera.get_region()
            self.payload_bytes: int = self._camera.get_payload()
            self.tick_frequency_hz: int = self._device.get_timestamp_tick_frequency()

    def in_control(self) -> bool:
        """Return whether the camera still obeys this process; losing control is silent."""
        return bool(self._device.is_controller())

    def answers(self) -> bool:
        """Ask the camera; False where it is silent or obeys another."""
        return answers_ping(self._settings.address) and self.in_control()

    def start(self, trigger: Trigger, ring: Ring, free_slots: Iterable[int]) -> FrameStream:
        """Begin to acquire into the free slots of the ring."""
        with self._talking():
            self._set_trigger(trigger)
            opened = open_stream(self._camera)
            if opened is None:
                raise CameraError(f"camera {self._settings.address} gives no stream; open it again")
            frames = FrameStream(opened, ring, self.payload_bytes)
            for slot in free_slots:
                frames.lend(slot)
            self._camera.start_acquisition()
            return frames

    def stop(self) -> None:
        """Stop acquiring; a camera that is gone has stopped."""
        with contextlib.suppress(GLib.Error):
            self._camera.stop_acquisition()

    def trigger(self) -> None:
        """Expose once, by command."""
        with self._talking():
            self._camera.software_trigger()

    def close(self, *, lost: bool) -> None:
        """Let go of a camera that is there or `lost`; it can be opened again after."""
        remains = [self._device, self._camera]
        del self._device, self._camera
        if lost:
            bury(remains)

    def description(self) -> dict[str, str]:
        """Return what the camera is and how it is set, for the recording."""
        with self._talking():
            values = {
                "sensor": self._settings.id,
                "address": self._settings.address,
                "vendor": self._camera.get_vendor_name(),
                "model": self._camera.get_model_name(),
                "serial": self._camera.get_device_serial_number(),
                "width": self.width,
                "height": self.height,
                "pixel_format": self._camera.get_pixel_format_as_string(),
                "packet_size": self._camera.gv_get_packet_size(),
                "frame_rate_hz": self._camera.get_frame_rate(),
                "exposure_us": self._camera.get_exposure_time(),
                "gain_db": self._camera.get_gain(),
                "tick_frequency_hz": self.tick_frequency_hz,
            }
        return {name: str(value) for name, value in values.items()}

    def _set_up(self) -> None:
        camera, settings = self._camera, self._settings
        if camera.get_pixel_format_as_string() != _PIXEL_FORMAT:
            camera.set_pixel_format_from_string(_PIXEL_FORMAT)
        camera.set_acquisition_mode(Aravis.AcquisitionMode.CONTINUOUS)
        # Not "auto": Aravis then takes packets that the path does not carry.
        camera.gv_set_packet_size(settings.packet_size)
        if settings.exposure_us is not None:
            self._check("exposure", settings.exposure_us, "us", camera.get_exposure_time_bounds())
            camera.set_exposure_time(settings.exposure_us)
        if settings.gain_db is not None:
            self._check("gain", settings.gain_db, "dB", camera.get_gain_bounds())
            camera.set_gain(settings.gain_db)
        self._set_frame_rate()

    def _set_frame_rate(self) -> None:
        rate_hz = self._settings.frame_rate_hz
        self._check("frame rate", rate_hz, "Hz", self._camera.get_frame_rate_bounds())
        self._camera.set_frame_rate(rate_hz)

    def _set_trigger(self, trigger: Trigger) -> None:
        # The frame rate first: setting it clears the triggers.
        self._camera.clear_triggers()
        self._set_frame_rate()
        if trigger is Trigger.SOFTWARE:
            self._camera.set_trigger("Software")
        elif trigger is Trigger.LINE1:
            self._camera.set_trigger("Line1")

    def _check(self, name: str, value: float, unit: str, bounds: Any) -> None:
        low, high = bounds
        if not (low <= value <= high):
            raise CameraRefused(
                f"{name} {value:g} {unit} is asked of camera {self._settings.address}; "
                f"it takes {low:g} to {high:g} {unit}: change the sensor's settings"
            )

    @contextlib.contextmanager
    def _talking(self) -> Generator[None, None, None]:
        """Turn the driver's errors into the station's."""
        try:
            yield
        except GLib.Error as error:
            address = self._settings.address
            if self.answers():
                raise CameraRefused(f"camera {address} refuses: {error.message}") from error
            raise CameraLost(
                f"camera {address} stopped answering ({error.message}); check power and cable"
            ) from error


def _unopened(address: str, error: Any) -> CameraError:
    if error.matches(Aravis.device_error_quark(), Aravis.DeviceError.NOT_CONTROLLER):
        return CameraRefused(f"camera {address} is controlled by another program; end that first")
    return CameraUnreachable(
        f"camera {address} answers but cannot be opened: {error.message}; try again in a minute"
    )
