"""A simulated GigE Vision camera on an address of this host."""

import contextlib
import errno
import ipaddress
import select
import socket
import threading
from collections.abc import Callable
from types import TracebackType
from typing import Self

from station.errors import CameraError, InputUnusable
from station.simulated import gvcp
from station.simulated import registers as reg
from station.simulated.counters import Statistics
from station.simulated.device import Device, DeviceOptions
from station.simulated.faults import Faults
from station.simulated.gvcp import MalformedPacket, Request
from station.simulated.identity import Identity
from station.simulated.sources import FrameSource
from station.software import SOFTWARE

VENDOR = "Treadline"
MODEL = "Simulated NIR camera"
_DATAGRAM_BYTES = 2048
_STOP_TIMEOUT_S = 10.0
_ANOTHER_PROGRAM = ("192.0.2.1", 1)  # an address of nobody: RFC 5737


class SimulatedCamera:
    """A camera that a GigE Vision driver cannot tell from a real one.

    It listens on the GVCP port of `address`; any 127.x.y.z will do, and several cameras stand
    side by side on one host. Pictures come from `source`, byte for byte. Use it as a context
    manager, or call `start` and `stop`.
    """

    def __init__(
        self,
        address: str,
        source: FrameSource,
        *,
        serial: str | None = None,
        faults: Faults | None = None,
        options: DeviceOptions | None = None,
    ) -> None:
        """Prepare a camera; nothing is heard or sent before `start`.

        Raises
        ------
        InputUnusable
            If `address` is no IPv4 address or the pictures are too small to be sent.
        """
        self._identity = Identity(
            address=parse_address(address),
            vendor=VENDOR,
            model=MODEL,
            version=SOFTWARE,
            serial=serial or f"SIM-{address.removeprefix('127.')}",
        )
        if min(source.width, source.height) < reg.MIN_REGION_PX:
            raise InputUnusable(
                f"pictures of {source.width} × {source.height} px; a simulated camera serves "
                f"{reg.MIN_REGION_PX} × {reg.MIN_REGION_PX} px and more"
            )
        self._source = source
        self._faults = faults or Faults()
        self._options = options or DeviceOptions()
        self._device: Device | None = None
        self._sockets: list[socket.socket] = []
        self._threads: list[threading.Thread] = []
        self._failure: Exception | None = None
        self._final = Statistics()

    @property
    def address(self) -> str:
        return str(self._identity.address)

    @property
    def serial(self) -> str:
        return self._identity.serial

    @property
    def failure(self) -> Exception | None:
        """What ended the camera by itself, such as a source that gave no picture."""
        return self._failure

    def start(self) -> None:
        """Begin to listen.

        Raises
        ------
        InputUnusable
            If the address is taken or not one of this host.
        """
        if self._device is not None:
            return
        listener = _listen(self._identity.address)
        self._device = Device(self._identity, self._source, self._faults, self._options)
        wake, woken = socket.socketpair()
        self._sockets = [wake, woken, listener, *_broadcast_listeners()]
        loops: tuple[Callable[[Device], None], ...] = (
            lambda device: self._serve(device, listener, woken),
            Device.expose_forever,
            Device.transmit_forever,
        )
        for name, loop in zip(("control", "sensor", "link"), loops, strict=True):
            self._start_thread(f"{self.serial} {name}", loop, self._device)

    def stop(self) -> None:
        """Fall silent and give the address back; safe to call twice.

        Raises
        ------
        CameraError
            If the camera had stopped by itself: its source gave no picture.
        """
        if self._device is None:
            return
        self._sockets[0].send(b"\0")
        self._device.close()
        for thread in self._threads:
            thread.join(_STOP_TIMEOUT_S)
        self._device.close_stream()
        for each in self._sockets:
            each.close()
        self._final = self._device.statistics()
        self._device, self._sockets, self._threads = None, [], []
        if self._failure is not None:
            failure, self._failure = self._failure, None
            raise CameraError(f"{self.serial} stopped by itself: {failure}") from failure

    def __enter__(self) -> Self:
        self.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()

    def trigger_line1(self, timestamp_ns: int | None = None) -> bool:
        """Raise the trigger line; return whether the camera exposes.

        Parameters
        ----------
        timestamp_ns
            UTC, ns, what the picture will carry as its time; now where absent.
        """
        device = self._running()
        return device.acquisition.trigger(reg.TriggerSource.LINE1, timestamp_ns)

    def freeze(self) -> None:
        """Answer and send nothing, as behind a cut cable; exposures go on."""
        self._running().frozen = True

    def thaw(self) -> None:
        """Answer and send again."""
        self._running().frozen = False

    def oust(self) -> None:
        """Take control from whoever has it, for another program that then falls silent."""
        self._running().control.oust(_ANOTHER_PROGRAM)

    @property
    def played_out(self) -> bool:
        """It has shown the last picture of what it played, and whoever received it has stopped."""
        return self._device is not None and self._device.acquisition.played_out

    def statistics(self) -> Statistics:
        """Return what the camera has done since `start`, also after `stop`."""
        return self._final if self._device is None else self._device.statistics()

    def _running(self) -> Device:
        if self._device is None:
            raise CameraError(f"{self.serial} does not run; start it first")
        return self._device

    def _start_thread(self, name: str, loop: Callable[[Device], None], device: Device) -> None:
        def run() -> None:
            try:
                loop(device)
            except Exception as error:  # the thread's last chance to say why it ends
                self._failure = error
                device.frozen = True

        thread = threading.Thread(target=run, name=name, daemon=True)
        self._threads.append(thread)
        thread.start()

    def _serve(self, device: Device, listener: socket.socket, woken: socket.socket) -> None:
        heard = self._sockets[1:]
        while True:
            left_s = device.control.seconds_to_expiry()
            timeout_s = None if left_s is None else max(0.0, left_s)
            ready, _, _ = select.select(heard, [], [], timeout_s)
            if woken in ready:
                return
            device.control.expire()
            for each in ready:
                # Readiness is a hint; and an answer may have no way back to whoever asked.
                with contextlib.suppress(OSError):
                    self._answer(device, each, listener)

    def _answer(self, device: Device, heard_by: socket.socket, listener: socket.socket) -> None:
        datagram, sender = heard_by.recvfrom(_DATAGRAM_BYTES)
        discovery = _is_discovery(datagram)
        if device.frozen or not (discovery or heard_by is listener):
            return
        if discovery and not self._may_find(sender[0]):
            return
        answer = device.control.handle(datagram, sender)
        if answer is not None:
            listener.sendto(answer, sender)

    def _may_find(self, sender_address: str) -> bool:
        # A loopback camera found through a network interface would be unusable from there:
        # drivers listen for the stream on the interface on which they found the camera.
        own, other = self._identity.address, ipaddress.ip_address(sender_address)
        return not own.is_loopback or other.is_loopback


def _is_discovery(datagram: bytes) -> bool:
    try:
        return Request.decode(datagram).command == gvcp.Command.DISCOVERY
    except MalformedPacket:
        return False


def parse_address(text: str) -> ipaddress.IPv4Address:
    """Return the address that a text names, or refuse it in one line."""
    try:
        return ipaddress.IPv4Address(text)
    except ValueError as error:
        raise InputUnusable(
            f"{text!r} is no IPv4 address; give one of this host, such as 127.0.0.5"
        ) from error


def _listen(address: ipaddress.IPv4Address) -> socket.socket:
    listener = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    listener.setblocking(False)
    try:
        listener.bind((str(address), gvcp.PORT))
    except OSError as error:
        listener.close()
        raise InputUnusable(_why_not(address, error)) from error
    return listener


def _why_not(address: ipaddress.IPv4Address, error: OSError) -> str:
    if error.errno == errno.EADDRINUSE:
        return (
            f"{address} port {gvcp.PORT} is in use, perhaps by another simulated camera; "
            "stop that one or give another address, such as 127.0.0.6"
        )
    if error.errno == errno.EADDRNOTAVAIL:
        return f"{address} is no address of this host; any 127.x.y.z is, such as 127.0.0.5"
    return f"{address} port {gvcp.PORT} cannot be listened on ({error.strerror}); try 127.0.0.5"


def _broadcast_listeners() -> list[socket.socket]:
    """Return the socket on which drivers ask who is there.

    None where another program holds the broadcast address for itself: the camera is then found
    by its address alone.
    """
    listener = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    listener.setblocking(False)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listener.bind(("255.255.255.255", gvcp.PORT))
    except OSError:
        listener.close()
        return []
    return [listener]
