"""Room in the kernel for packets that wait: what the receiver would be granted."""

import math
import os
import socket
from collections.abc import Sequence
from dataclasses import dataclass

from station.doctor.demand import Stream
from station.doctor.finding import Finding, judged, megabytes
from station.doctor.host import Host, to_keep

WANTED_BYTES = 64 << 20
"""What the driver asks for; the kernel doubles it for its own bookkeeping."""
_CAP_NET_ADMIN, _CAP_NET_RAW = 12, 13
_SO_RCVBUFFORCE = 33  # Linux; the module `socket` does not name it
_PACKET_COST_BYTES = 16 << 10
"""What the kernel counts for a packet of 9000 bytes."""


@dataclass(frozen=True, slots=True)
class Rights:
    """What this program may do to the network; root, systemd or `setcap` grant it."""

    net_admin: bool
    """CAP_NET_ADMIN: receive buffers of any size."""
    net_raw: bool
    """CAP_NET_RAW: the packet socket, which needs no receive buffer."""

    @classmethod
    def of(cls, host: Host) -> "Rights":
        """Read the effective capabilities of this process."""
        effective = int(host.field("proc/self/status", "CapEff") or "0", 16)
        return cls(bool(effective >> _CAP_NET_ADMIN & 1), bool(effective >> _CAP_NET_RAW & 1))


def granted_bytes() -> int:
    """Ask for the receive buffer as the driver does; return what the kernel grants."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as asking:
        try:
            asking.setsockopt(socket.SOL_SOCKET, _SO_RCVBUFFORCE, WANTED_BYTES)
        except PermissionError:
            asking.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, WANTED_BYTES)
        return asking.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)


def judge_receive_buffer(
    granted: int, rights: Rights, host: Host, streams: Sequence[Stream]
) -> Finding:
    """Judge where packets wait while the receiver is held up; what finds no room is lost."""
    held_s = min((_held_s(granted, stream) for stream in streams), default=math.inf)
    bridged = f", {held_s:.2g} s of the fastest camera" if math.isfinite(held_s) else ""
    limit, default = host.sysctl("net.core.rmem_max"), host.sysctl("net.core.rmem_default")
    seen = (
        f"{megabytes(granted)} granted{bridged} (net.core.rmem_max {limit}, rmem_default "
        f"{default}, CAP_NET_ADMIN {_yes(rights.net_admin)}, CAP_NET_RAW {_yes(rights.net_raw)}"
        f"{', asked as root' if os.geteuid() == 0 else ''})"
    )
    good = granted >= 2 * WANTED_BYTES
    return judged(
        "receive buffer", seen, good=good, cure=to_keep("net.core.rmem_max", WANTED_BYTES)
    )


def judge_backlog(host: Host, streams: Sequence[Stream]) -> Finding:
    """Judge the queue before the sockets: the cameras may send a frame each at once."""
    name = "net.core.netdev_max_backlog"
    length = host.sysctl(name) or 0
    needed = sum(stream.packets_per_frame for stream in streams)
    seen = f"{name} {length}, a frame of every camera is {needed} packets"
    return judged("backlog", seen, good=length >= needed, cure=to_keep(name, max(2 * needed, 1000)))


def _held_s(granted: int, stream: Stream) -> float:
    # A smaller packet costs less, though not in proportion: memory comes in powers of two.
    cost = min(_PACKET_COST_BYTES, 2 * stream.packet_size)
    return granted / cost / (stream.packets_per_frame * stream.frame_rate_hz)


def _yes(granted: bool) -> str:
    return "yes" if granted else "no"
