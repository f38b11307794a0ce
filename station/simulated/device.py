"""The simulated device without its control socket: registers, sensor and stream put together."""

import queue
import time
from dataclasses import dataclass
from ipaddress import IPv4Address

import cv2
import numpy as np

from calib import Picture
from station.simulated import registers as reg
from station.simulated.acquisition import Acquisition, Exposure, ExposureSettings
from station.simulated.control import ControlChannel
from station.simulated.counters import Statistics
from station.simulated.device_clock import DeviceClock
from station.simulated.faults import FaultInjector, Faults
from station.simulated.gvcp import ResendRequest
from station.simulated.gvsp import BlockHeader
from station.simulated.identity import Identity
from station.simulated.memory import CameraMemory
from station.simulated.playback import Playback
from station.simulated.sources import FrameSource, LaserSwitched
from station.simulated.stream import StreamChannel

_PICTURES_ON_THEIR_WAY = 64


@dataclass(frozen=True, slots=True)
class DeviceOptions:
    """How a simulated device differs from the others.

    `frame_rate_hz` is what AcquisitionFrameRate says at the start; `resend_frames` is how many
    pictures are kept for sending packets again; `first_block_id` lets a test begin just before
    block ids wrap. `clock` is how its clock goes; a camera without one has tick frequency 0.
    """

    frame_rate_hz: float = 53.0
    resend_frames: int = 16
    first_block_id: int = 1
    clock: DeviceClock = DeviceClock()

    def __post_init__(self) -> None:
        if not (reg.MIN_FRAME_RATE_HZ <= self.frame_rate_hz <= reg.MAX_FRAME_RATE_HZ):
            raise ValueError(
                f"frame_rate_hz must be {reg.MIN_FRAME_RATE_HZ} to {reg.MAX_FRAME_RATE_HZ}, "
                f"got {self.frame_rate_hz}"
            )
        if not (self.resend_frames >= 1 and 1 <= self.first_block_id <= 65_535):
            raise ValueError(
                f"resend_frames must be 1 or more and first_block_id 1 to 65535, "
                f"got {self.resend_frames} and {self.first_block_id}"
            )


class Device:
    """Exposes, sends and obeys; the threads that call it belong to `SimulatedCamera`."""

    def __init__(
        self, identity: Identity, source: FrameSource, faults: Faults, options: DeviceOptions
    ) -> None:
        self._source = source
        self._delay_s = faults.delay_s
        self._faults = FaultInjector(faults)
        self._counters = Statistics()
        self._ready: queue.Queue[tuple[Exposure, Picture] | None] = queue.Queue(
            _PICTURES_ON_THEIR_WAY
        )
        self.frozen = False
        self.memory = CameraMemory(identity, source.width, source.height, options.frame_rate_hz)
        self.acquisition = Acquisition(
            lambda: ExposureSettings.of(self.memory, options.frame_rate_hz),
            first_block_id=options.first_block_id,
            playback=source if isinstance(source, Playback) else None,
        )
        self._clock = options.clock
        if not options.clock.ticks:
            self.memory.put(reg.TICK_FREQUENCY_LOW, 0)
        self.memory.is_acquiring = lambda: self.acquisition.running
        self._stream = StreamChannel(
            identity.address, self._faults, self._counters, resend_frames=options.resend_frames
        )
        self.memory.put(reg.STREAM_SOURCE_PORT, self._stream.source_port)
        self.control = ControlChannel(self.memory, self)

    def statistics(self) -> Statistics:
        return self._counters.snapshot(
            exposed=self.acquisition.exposed, missed_triggers=self.acquisition.missed_triggers
        )

    def close(self) -> None:
        """End `expose_forever` and `transmit_forever`."""
        self.acquisition.close()

    def close_stream(self) -> None:
        """Give the stream socket back, after the threads have ended."""
        self._stream.close()

    def expose_forever(self) -> None:
        """Take pictures until closed."""
        try:
            while exposure := self.acquisition.next_exposure():
                picture = exposure.picture
                if picture is None:
                    picture = self._look(exposure.index, exposure.settings)
                self._check(picture)
                self._ready.put((exposure, picture))
        finally:
            self.acquisition.close()
            self._ready.put(None)

    def _look(self, index: int, settings: ExposureSettings) -> Picture:
        source, exposure_us = self._source, settings.gained_exposure_us
        if settings.laser or not isinstance(source, LaserSwitched):
            picture = source.frame(index, exposure_us)
        else:
            picture = source.frame_laser_off(index, exposure_us)
        if settings.black_level > 0.0:
            level = settings.black_level
            picture = np.asarray(cv2.convertScaleAbs(picture, beta=level), dtype=np.uint8)
        return picture

    def transmit_forever(self) -> None:
        """Send pictures until no more come."""
        while taken := self._ready.get():
            exposure, picture = taken
            time.sleep(max(0.0, exposure.ready_s + self._delay_s - time.monotonic()))
            if self._transmit(exposure, picture):
                self._counters.sent += 1
            else:
                self._counters.lost_frames += 1

    def register_written(self, register: reg.Register, value: int) -> None:
        """Do what writing the register means."""
        if register is reg.ACQUISITION_START and value:
            self._stream.forget()
            self.acquisition.start()
        elif register is reg.ACQUISITION_STOP and value:
            self.acquisition.stop()
        elif register is reg.TRIGGER_SOFTWARE and value:
            self.acquisition.trigger(reg.TriggerSource.SOFTWARE)
        elif register is reg.TIMESTAMP_CONTROL and value & reg.TIMESTAMP_LATCH:
            self._latch_timestamp()
        elif register in {reg.STREAM_PORT, reg.STREAM_ADDRESS}:
            self._connect_stream()
        elif register is reg.STREAM_PACKET_SIZE:
            self._size_written(value)
        self.acquisition.settings_changed()

    def resend_requested(self, request: ResendRequest) -> None:
        self._stream.send_again(request)

    def control_lost(self) -> None:
        self.acquisition.stop()
        self.memory.put(reg.TL_PARAMS_LOCKED, 0)
        self.memory.put(reg.STREAM_PORT, 0)
        self._connect_stream()

    def _transmit(self, exposure: Exposure, picture: Picture) -> bool:
        lost = self._faults.loses_frame(exposure.index)
        outdated = exposure.acquisition != self.acquisition.number
        if lost or outdated or self.frozen:
            return False
        region = exposure.settings.region
        camera_ns = self._clock.camera_ns(exposure.timestamp_ns)
        header = BlockHeader(exposure.block_id, camera_ns, region)
        return self._stream.send_frame(
            header,
            region.cut(picture),
            packet_bytes=self.memory.packet_bytes,
            delay_ns=self.memory.get(reg.STREAM_PACKET_DELAY),
        )

    def _check(self, picture: Picture) -> None:
        wanted = (self._source.height, self._source.width)
        if not (picture.shape == wanted and picture.dtype == np.uint8):
            raise ValueError(
                f"the source gave {picture.dtype} pixels of shape {picture.shape}; "
                f"it said uint8 of shape {wanted}"
            )

    def _connect_stream(self) -> None:
        address = IPv4Address(self.memory.get(reg.STREAM_ADDRESS))
        self._stream.connect(address, self.memory.get(reg.STREAM_PORT))

    def _size_written(self, value: int) -> None:
        self.memory.put(reg.STREAM_PACKET_SIZE, value & ~reg.SCPS_FIRE_TEST_PACKET)
        if value & reg.SCPS_FIRE_TEST_PACKET:
            self._stream.send_test_packet(value & reg.SCPS_SIZE_MASK)

    def _latch_timestamp(self) -> None:
        now_ns = self._clock.camera_ns(time.time_ns())
        self.memory.put(reg.TIMESTAMP_HIGH, now_ns >> 32)
        self.memory.put(reg.TIMESTAMP_LOW, now_ns & 0xFFFF_FFFF)
