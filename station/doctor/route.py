"""The way to a camera: which interface, how large a packet it carries, how fast it is."""

import array
import contextlib
import fcntl
import os
import socket
import struct
import time
from dataclasses import dataclass

from station.doctor.demand import Stream
from station.doctor.finding import Finding, judged
from station.doctor.host import Host, as_root

_IP_MTU_DISCOVER, _IP_PMTUDISC_DO, _IP_MTU = 10, 2, 14  # Linux; `socket` does not name them
_SIOCGIFADDR = 0x8915
_ANY_PORT = 9  # connecting a datagram socket sends nothing
_ECHO_WAIT_S = 0.3
_ECHO_TRIES = 2
_ECHO_REQUEST, _ECHO_REPLY = 8, 0
_ECHO = struct.Struct(">BBHHH")
_IP_HEADER_BYTES = 20
_SMALL_BYTES = 64


@dataclass(frozen=True, slots=True)
class Route:
    """The way to an address, as this host sees it."""

    interface: str | None
    mtu: int
    """The largest packet that leaves this host, bytes, headers included."""
    speed_mbit: int | None
    """Of the interface; None where it does not say."""
    carries: bool | None
    """Whether an echo of the packet size came back; None where not even a small one did."""


def probe_route(stream: Stream, host: Host) -> Route:
    """Look at the way to a camera; OSError where there is none."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asking:
        asking.setsockopt(socket.IPPROTO_IP, _IP_MTU_DISCOVER, _IP_PMTUDISC_DO)
        asking.connect((stream.address, _ANY_PORT))
        mtu = asking.getsockopt(socket.IPPROTO_IP, _IP_MTU)
        interface = _interface_of(asking.getsockname()[0])
    speed = None if interface is None else host.number(f"sys/class/net/{interface}/speed")
    carries = None
    if _echoes(stream.address, _SMALL_BYTES):
        carries = _echoes(stream.address, stream.packet_size)
    # A virtual interface says -1.
    return Route(interface, mtu, speed if speed and speed > 0 else None, carries)


def judge_packet_size(stream: Stream, route: Route) -> Finding:
    """Judge the packet size: what the path does not carry is dropped without a word."""
    name = f"packets of {stream.sensor}"
    interface = route.interface or "the interface of `ip route get`"
    if route.mtu < stream.packet_size:
        return Finding(
            name,
            f"{interface} carries {route.mtu} bytes, packet_size is {stream.packet_size}",
            f"{as_root(f'ip link set dev {interface} mtu {stream.packet_size}')}, or packet_size = "
            f"{route.mtu} in the settings of {stream.sensor}",
        )
    asked = {
        True: "an echo of that size came back",
        False: "an echo of that size does not come back, a small one does",
        None: "no echo from the camera: the switch is not proved",
    }[route.carries]
    seen = f"{interface} carries {route.mtu} bytes, packet_size is {stream.packet_size}; {asked}"
    cure = (
        f"turn on jumbo frames in the switch, or set packet_size = 1500 in the settings of "
        f"{stream.sensor}"
    )
    return judged(name, seen, good=route.carries is not False, cure=cure)


def judge_link_speed(interface: str, speed_mbit: int, bytes_per_s: float) -> Finding:
    """Judge an interface: what it cannot carry of its cameras is dropped."""
    needed_mbit = bytes_per_s * 8e-6
    seen = f"{speed_mbit} Mbit/s, its cameras send {needed_mbit:.0f} Mbit/s"
    cure = (
        f"look at cable and switch port of {interface} (ethtool {interface}), or lower "
        "frame_rate_hz of its sensors"
    )
    return judged(f"link {interface}", seen, good=speed_mbit >= needed_mbit, cure=cure)


def _interface_of(own_address: str) -> str | None:
    """Return the interface that has an address of this host."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asking:
        for _, name in socket.if_nameindex():
            request = array.array("B", name.encode().ljust(40, b"\0"))
            with contextlib.suppress(OSError):  # it has no address
                fcntl.ioctl(asking, _SIOCGIFADDR, request)
                if socket.inet_ntoa(request[20:24].tobytes()) == own_address:
                    return name
    return None


def _echoes(address: str, packet_bytes: int) -> bool:
    """Send an echo request of so many bytes, IP header included; whether the answer came."""
    body = os.urandom(packet_bytes - _IP_HEADER_BYTES - _ECHO.size)
    with contextlib.suppress(OSError), _icmp_socket() as asking:
        asking.setsockopt(socket.IPPROTO_IP, _IP_MTU_DISCOVER, _IP_PMTUDISC_DO)
        for number in range(_ECHO_TRIES):
            asking.sendto(_echo_request(number, body), (address, 0))
            if _answered(asking, body):
                return True
    return False


def _icmp_socket() -> socket.socket:
    """Open a socket for echoes: the unprivileged kind where this user's group may, or a raw one."""
    try:
        return socket.socket(socket.AF_INET, socket.SOCK_DGRAM, socket.IPPROTO_ICMP)
    except PermissionError:
        return socket.socket(socket.AF_INET, socket.SOCK_RAW, socket.IPPROTO_ICMP)


def _echo_request(number: int, body: bytes) -> bytes:
    identity = os.getpid() & 0xFFFF
    head = _ECHO.pack(_ECHO_REQUEST, 0, 0, identity, number)
    return _ECHO.pack(_ECHO_REQUEST, 0, _checksum(head + body), identity, number) + body


def _checksum(packet: bytes) -> int:
    """RFC 1071: the one's complement of the one's complement sum of 16-bit words."""
    padded = packet + b"\0" * (len(packet) % 2)
    total: int = sum(struct.unpack(f">{len(padded) // 2}H", padded))
    while total >> 16:
        total = (total & 0xFFFF) + (total >> 16)
    return ~total & 0xFFFF


def _answered(asking: socket.socket, body: bytes) -> bool:
    """Wait for the answer; the body is random, so no other echo is taken for it."""
    until_s = time.monotonic() + _ECHO_WAIT_S
    while (left_s := until_s - time.monotonic()) > 0.0:
        asking.settimeout(left_s)
        received = asking.recv(1 << 16)
        head = received[-len(body) - _ECHO.size :]
        if received.endswith(body) and head[0] == _ECHO_REPLY:
            return True
    return False
