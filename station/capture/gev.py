"""What a GigE Vision camera can be asked for by its registers, beside its features.

The bootstrap registers stand at the same place in every such camera, whatever its description
says.
"""

import socket
import struct
import time
from typing import Any

from station.capture.aravis import GLib
from station.capture.clock import ClockSample
from station.capture.ping import answers_ping

_HEARTBEAT_TIMEOUT = 0x0938
_TIMESTAMP_CONTROL, _LATCH = 0x0944, 2
_TIMESTAMP_HIGH, _TIMESTAMP_LOW = 0x0948, 0x094C
_STREAM_PORT, _STREAM_ADDRESS = 0x0D00, 0x0D18
_PACKET_SIZE, _FIRE_TEST_PACKET, _DO_NOT_FRAGMENT = 0x0D04, 0x8000_0000, 0x4000_0000
_IP_UDP_BYTES = 28
_TEST_PACKETS = 3
_TEST_PACKET_WAIT_S = 0.1
_NS_PER_S = 1_000_000_000


class GevLink:
    """The control channel of an open GigE Vision camera."""

    def __init__(self, device: Any, address: str, tick_frequency_hz: int) -> None:
        self._device = device
        self._address = address
        self._tick_frequency_hz = tick_frequency_hz

    def answers(self) -> bool:
        """Return whether the camera is there, whoever controls it."""
        return answers_ping(self._address)

    def obeys(self) -> bool:
        """Return whether the camera takes a write from here: a silent camera takes 2.5 s.

        Reading tells nothing: the register of control says that somebody controls the camera, not
        who.  So a value is written that was there before.
        """
        try:
            timeout_ms = self._device.read_register(_HEARTBEAT_TIMEOUT)
            self._device.write_register(_HEARTBEAT_TIMEOUT, timeout_ms)
        except GLib.Error:
            return False
        return True

    def clock_sample(self) -> ClockSample | None:
        """Note the camera's time and this host's; None where the camera cannot tell its own."""
        if self._tick_frequency_hz <= 0:
            return None
        device = self._device
        try:
            before_ns = time.time_ns()
            device.write_register(_TIMESTAMP_CONTROL, _LATCH)
            after_ns = time.time_ns()
            high, low = device.read_register(_TIMESTAMP_HIGH), device.read_register(_TIMESTAMP_LOW)
        except GLib.Error:
            return None
        ticks = (high & 0xFFFF_FFFF) << 32 | low & 0xFFFF_FFFF
        if ticks == 0:
            return None
        return ClockSample(
            camera_ns=ticks * _NS_PER_S // self._tick_frequency_hz,
            host_ns=(before_ns + after_ns) // 2,
            within_ns=max(1, (after_ns - before_ns) // 2),
        )

    def carries(self, packet_bytes: int) -> bool:
        """Return whether a packet of this size, headers included, comes through from the camera.

        The camera is asked for test packets that no router may split; the stream must not be open.
        May raise GLib.Error.
        """
        own = self._device.get_interface_address().get_address().to_string()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
            receiver.bind((own, 0))
            receiver.settimeout(_TEST_PACKET_WAIT_S)
            (own_number,) = struct.unpack(">I", socket.inet_aton(own))
            self._write(_STREAM_ADDRESS, own_number)
            self._write(_STREAM_PORT, receiver.getsockname()[1])
            try:
                for _ in range(_TEST_PACKETS):
                    self._write(_PACKET_SIZE, _FIRE_TEST_PACKET | _DO_NOT_FRAGMENT | packet_bytes)
                    if _comes(receiver, packet_bytes - _IP_UDP_BYTES):
                        return True
            finally:
                self._write(_STREAM_PORT, 0)
        return False

    def _write(self, register: int, value: int) -> None:
        self._device.write_register(register, value)


def _comes(receiver: socket.socket, wanted_bytes: int) -> bool:
    try:
        return len(receiver.recv(wanted_bytes + 1)) == wanted_bytes
    except TimeoutError:
        return False
