"""The camera through Aravis: opened, set up in the order that works, triggered, watched."""

import contextlib
import traceback
from collections.abc import Generator, Iterable
from typing import Any

from station.capture.aravis import Aravis, GLib
from station.capture.burial import bury
from station.capture.clock import ClockSample
from station.capture.common_settings import CommonSettings
from station.capture.features import Features, Wanted
from station.capture.gev import GevLink
from station.capture.open_stream import open_stream
from station.capture.ping import answers_ping
from station.capture.plan import ExposureStep, Trigger
from station.capture.ring import Ring
from station.capture.setup import REPORTED, of_trigger, set_up, switched
from station.capture.stream import FrameStream
from station.errors import CameraError, CameraLost, CameraRefused, CameraUnreachable
from station.recording import EventKind
from station.settings import SensorSettings

FAKE = "Fake_1"
"""Aravis' own camera, within this process: a moving pattern in free run.

It has no network, so packets and resends are not tried by it; no clock; and by software trigger it
gives frames that nobody asked for, which a recording says.
"""
_PIXEL_FORMAT = "Mono8"
_TEMPERATURE = "DeviceTemperature"


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
        self.warnings: list[tuple[EventKind, str]] = []
        """What is not as it should be and lets frames come all the same."""
        self._camera = _opened(settings.address)
        self._device = self._camera.get_device()
        self._features = Features(self._device, settings.address)
        self._common = CommonSettings(self._camera, settings.address)
        self._link: GevLink | None = None
        self.tick_frequency_hz = 0
        try:
            with self._talking():
                self._get_acquainted()
                self._set_up()
                *_, self.width, self.height = self._camera.get_region()
                self.payload_bytes: int = self._camera.get_payload()
                gain_db = float(self._camera.get_gain())
                self._usual = ExposureStep(self.exposure_us, gain_db, laser=True)
                self._present = self._usual
        except CameraError as error:
            # While its traceback holds the camera, nobody can open it again.
            traceback.clear_frames(error.__traceback__)
            self.close(lost=isinstance(error, CameraLost))
            raise

    @property
    def exposure_us(self) -> float:
        """Exposure time, us."""
        return float(self._camera.get_exposure_time())

    @property
    def frame_rate_hz(self) -> float:
        """Frames a second in free run."""
        return float(self._camera.get_frame_rate())

    def answers(self) -> bool:
        """Return whether the camera is there, whoever controls it."""
        return self._settings.address == FAKE or answers_ping(self._settings.address)

    def obeys(self) -> bool:
        """Ask a camera that answers whether this process still controls it."""
        return self._link is None or (bool(self._device.is_controller()) and self._link.obeys())

    def temperature_c(self) -> float | None:
        """Return how warm the camera is, degrees Celsius; None where it does not tell."""
        if not self._features.has(_TEMPERATURE):
            return None
        with self._talking():
            return float(self._features.get(_TEMPERATURE))

    def clock_sample(self) -> ClockSample | None:
        """Ask for the camera's time; None where it does not tell."""
        return None if self._link is None else self._link.clock_sample()

    def start(self, trigger: Trigger, ring: Ring, free_slots: Iterable[int]) -> FrameStream:
        """Begin to acquire into the free slots of the ring.

        Raises
        ------
        CameraRefused
            If the camera does not take the trigger or the frame rate.
        CameraError
            If it gives no stream, or does not answer.
        """
        if self._present != self._usual:  # an exposure sequence ended otherwise
            self.expose_as(self._usual)
        with self._talking():
            self._set_trigger(trigger)
            opened = open_stream(self._camera)
            if opened is None:
                raise CameraError(f"camera {self._settings.address} gives no stream; open it again")
            self._warn(EventKind.RECEIVE_BUFFER, opened.warning)
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

    def expose_as(self, step: ExposureStep) -> ExposureStep:
        """Set exposure, gain and laser for the next frame; return what the camera made of them."""
        with self._talking():
            self._set_exposure(step.exposure_us, step.gain_db)
            if self._settings.laser_output is not None:
                output = self._settings.laser_output
                self._features.set(switched(output, step.laser, "laser_output"))
            gain_db = float(self._camera.get_gain())
            self._present = ExposureStep(self.exposure_us, gain_db, step.laser)
            return self._present

    def close(self, *, lost: bool) -> None:
        """Let go of a camera that is there or `lost`; it can be opened again after."""
        remains = [self._device, self._camera, self._features, self._common, self._link]
        del self._device, self._camera, self._features, self._common, self._link
        if lost:
            bury(remains)

    def description(self) -> dict[str, str]:
        """Return what the camera is and how it is set, for the recording."""
        camera, features = self._camera, self._features
        with self._talking():
            values = {
                "sensor": self._settings.id,
                "address": self._settings.address,
                "vendor": camera.get_vendor_name(),
                "model": camera.get_model_name(),
                "serial": camera.get_device_serial_number(),
                "width": self.width,
                "height": self.height,
                "pixel_format": camera.get_pixel_format_as_string(),
                "frame_rate_hz": camera.get_frame_rate(),
                "exposure_us": camera.get_exposure_time(),
                "gain_db": camera.get_gain(),
                "tick_frequency_hz": self.tick_frequency_hz,
            }
            if self._link is not None:
                values["packet_size"] = camera.gv_get_packet_size()
                values["packet_delay_ns"] = camera.gv_get_packet_delay()
            for name in (*REPORTED, *self._settings.features):
                if features.has(name):
                    values[f"feature.{name}"] = features.get(name)
            for wanted in self._kept:
                if wanted.under is not None:
                    values[f"setting.{wanted.setting}"] = wanted.value
        return {name: str(value) for name, value in values.items()}

    def _get_acquainted(self) -> None:
        if not self._camera.is_gv_device():
            return
        if not self._device.is_controller():
            raise ControlHeld(_taken(self._settings.address))
        self.tick_frequency_hz = self._device.get_timestamp_tick_frequency()
        self._link = GevLink(self._device, self._settings.address, self.tick_frequency_hz)

    def _set_up(self) -> None:
        camera, settings = self._camera, self._settings
        self._kept: tuple[Wanted, ...] = set_up(self._features, settings)
        if camera.get_pixel_format_as_string() != _PIXEL_FORMAT:
            camera.set_pixel_format_from_string(_PIXEL_FORMAT)
        camera.set_acquisition_mode(Aravis.AcquisitionMode.CONTINUOUS)
        self._set_packets()
        self._set_exposure(settings.exposure_us, settings.gain_db)
        self._set_trigger(Trigger(settings.trigger))
        for wanted in self._kept:
            self._features.ensure_holds(wanted)

    def _set_packets(self) -> None:
        if self._link is None:
            return
        if self._settings.packet_delay_ns is not None:
            self._common.set_packet_delay(self._settings.packet_delay_ns)
        size = self._common.set_packet_size(self._settings.packet_size, self._link.carries)
        self._warn(EventKind.PACKET_SIZE, size.warning)

    def _set_exposure(self, exposure_us: float | None, gain_db: float | None) -> None:
        if exposure_us is not None:
            self._common.set_exposure(exposure_us)
        if gain_db is not None:
            self._common.set_gain(gain_db)

    def _set_trigger(self, trigger: Trigger) -> None:
        self._common.set_trigger(trigger, self._settings.frame_rate_hz)
        for wanted in of_trigger(self._settings, trigger):
            self._features.set(wanted)

    def _warn(self, kind: EventKind, text: str | None) -> None:
        if text is not None and (kind, text) not in self.warnings:
            self.warnings.append((kind, text))

    @contextlib.contextmanager
    def _talking(self) -> Generator[None, None, None]:
        """Turn the driver's errors into the station's."""
        try:
            yield
        except GLib.Error as error:
            address = self._settings.address
            if self.answers() and self.obeys():
                raise CameraRefused(f"camera {address} refuses: {error.message}") from error
            raise CameraLost(
                f"camera {address} stopped answering ({error.message}); check power and cable"
            ) from error


class ControlHeld(CameraRefused):
    """Another program controls the camera, or one did that died a moment ago."""


def _opened(address: str) -> Any:
    if address == FAKE:
        Aravis.enable_interface("Fake")
    elif not answers_ping(address):
        raise CameraUnreachable(
            f"no camera answers at {address}; `station camera list` shows those in reach: "
            "check address, power and cable"
        )
    try:
        return Aravis.Camera.new(address)
    except GLib.Error as error:
        if error.matches(Aravis.device_error_quark(), Aravis.DeviceError.NOT_CONTROLLER):
            raise ControlHeld(_taken(address)) from error
        raise CameraUnreachable(
            f"camera {address} answers but cannot be opened: {error.message}; try again in a minute"
        ) from error


def _taken(address: str) -> str:
    return f"camera {address} is controlled by another program; end that first"
