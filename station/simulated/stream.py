"""The stream channel: sends pictures as GVSP packets, some of them badly, and sends them again."""

import contextlib
import socket
import threading
import time
from collections import deque
from collections.abc import Sequence
from ipaddress import IPv4Address

from calib import Picture
from station.simulated.counters import Statistics
from station.simulated.faults import FaultInjector
from station.simulated.gvcp import ResendRequest
from station.simulated.gvsp import (
    IP_UDP_BYTES,
    BlockHeader,
    FramePackets,
    as_resent,
    encode_unavailable,
)

MAX_UNAVAILABLE = 4096  # packets of one request; "all that follow" of a gone picture is told once
_SEND_BUFFER_BYTES = 4 << 20
_PACED_PACKETS = 16  # a sleep costs 60 us at least: one for each packet would be too coarse


class StreamChannel:
    """One GVSP stream from a device to the receiver that its controller names."""

    def __init__(
        self,
        address: IPv4Address,
        faults: FaultInjector,
        counters: Statistics,
        *,
        resend_frames: int,
    ) -> None:
        self._faults = faults
        self._counters = counters
        self._lock = threading.Lock()  # the packets kept for sending again have two users
        self._kept: deque[FramePackets] = deque()
        self._keep = resend_frames
        self._connected = False
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER_BYTES)
        self._socket.bind((str(address), 0))

    @property
    def source_port(self) -> int:
        port: int = self._socket.getsockname()[1]
        return port

    def connect(self, address: IPv4Address, port: int) -> None:
        """Send to this receiver from now on; port 0 or address 0.0.0.0 is nobody."""
        self._connected = False
        if port and int(address):
            with contextlib.suppress(OSError):  # no way there: a real camera's packets get lost too
                self._socket.connect((str(address), port))
                self._connected = True

    def close(self) -> None:
        self._connected = False
        self._socket.close()

    def send_test_packet(self, packet_bytes: int) -> None:
        """Send one packet that tells the receiver that this size gets through."""
        if self._connected:
            self._send_packet(b"\0" * (packet_bytes - IP_UDP_BYTES))

    def send_frame(
        self, header: BlockHeader, pixels: Picture, *, packet_bytes: int, delay_ns: int
    ) -> bool:
        """Send a picture with the faults drawn for it; return whether anything went out."""
        with self._lock:
            frame = self._slot(pixels.size, packet_bytes)
            frame.fill(header, pixels)
            self._kept.append(frame)
        if not self._connected:
            return False
        order = self._faults.transmission(len(frame.packets))
        self._count_faults(len(frame.packets), order)
        self._send_paced([frame.packets[i] for i in order], delay_ns)
        return len(order) > 0

    def send_again(self, request: ResendRequest) -> None:
        """Send packets again, or say of each that it is gone."""
        self._counters.resend_requests += 1
        with self._lock:
            kept = (frame for frame in self._kept if frame.block_id == request.block_id)
            packets = next((frame.packets for frame in kept), None)
            if packets is None:
                self._say_unavailable(request)
                return
            # A request may reach beyond the last packet: "and all that follow".
            for packet in packets[request.first_packet : request.last_packet + 1]:
                self._send_packet_again(packet)

    def forget(self) -> None:
        """Drop the packets kept: block ids begin anew."""
        with self._lock:
            for frame in self._kept:
                frame.block_id = None

    def _slot(self, payload_bytes: int, packet_bytes: int) -> FramePackets:
        """Return memory for one more picture: the oldest one's where it fits."""
        if len(self._kept) >= self._keep:
            oldest = self._kept.popleft()
            if (oldest.payload_bytes, oldest.packet_bytes) == (payload_bytes, packet_bytes):
                return oldest
        return FramePackets(payload_bytes, packet_bytes)

    def _count_faults(self, count: int, order: Sequence[int]) -> None:
        if isinstance(order, range):
            return
        distinct = len(set(order))
        self._counters.dropped_packets += count - distinct
        self._counters.duplicated_packets += len(order) - distinct

    def _send_paced(self, packets: list[memoryview], delay_ns: int) -> None:
        begun_s = time.monotonic()
        for i, packet in enumerate(packets):
            if delay_ns and i % _PACED_PACKETS == 0:
                time.sleep(max(0.0, begun_s + i * delay_ns * 1e-9 - time.monotonic()))
            self._send_packet(packet)

    def _say_unavailable(self, request: ResendRequest) -> None:
        asked = range(request.first_packet, request.last_packet + 1)
        told = asked if len(asked) <= MAX_UNAVAILABLE else asked[:1]
        for packet_id in told:
            self._counters.unavailable_packets += 1
            self._send_packet(encode_unavailable(request.block_id, packet_id))

    def _send_packet_again(self, packet: memoryview) -> None:
        if self._faults.blocks(len(packet) + IP_UDP_BYTES):
            return
        if self._faults.loses_resent_packet():
            self._counters.dropped_resends += 1
            return
        self._counters.resent_packets += 1
        with contextlib.suppress(OSError):
            self._socket.sendmsg(as_resent(packet))

    def _send_packet(self, packet: bytes | memoryview) -> None:
        # A receiver that has gone answers with ICMP, which shows as an error here. To a real
        # camera that packet is simply sent.
        if self._faults.blocks(len(packet) + IP_UDP_BYTES):
            return
        with contextlib.suppress(OSError):
            self._socket.send(packet)
