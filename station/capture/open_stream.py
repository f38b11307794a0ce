"""Opening a camera's stream with room for packets that wait while the receiver is held up.

Aravis 0.8.26 offers two ways to receive, and neither is right as it comes:

- Its packet socket (AF_PACKET, needs CAP_NET_RAW) takes the packets of *every* stream on the host
  until its filter is set, and believes the first to be the camera's: armed while another camera
  streams, it discards up to a hundred of the first frames as late.  Its ring holds only 80 ms, and
  it measures the age of the first frame after a pause from before the pause.
- Its plain socket has the buffer the kernel grants, by default a tenth of a frame; Aravis can ask
  for one frame's worth, 19 ms.

So the plain socket is used and given a buffer for half a second.  CAP_NET_ADMIN allows any size;
without it ``net.core.rmem_max`` is the limit, and where that is low the packet socket remains.
"""

import contextlib
import os
import socket
import stat
import time
from dataclasses import dataclass, replace
from typing import Any

from station.capture.aravis import Aravis

_WANTED_BYTES = 64 << 20
"""The kernel doubles it and counts its own bookkeeping: a packet of 9000 bytes takes 16 kB."""
_ENOUGH_BYTES = 16 << 20
"""Four frames of 2048 x 1088; below, the packet socket is the better one."""
_SO_RCVBUFFORCE = 33  # Linux; the module `socket` does not name it

_PLAIN_RETENTION_US = 500_000
"""How long a frame waits for a packet that does not come; all behind it wait too, in the ring."""
_PACKET_SOCKET_RETENTION_US = 5_000_000
_REQUEST_RATIO = 1.0
"""Share of a frame's packets that may be asked for again.  A receiver held up can miss most of a
frame; by default Aravis gives up beyond a quarter and lets the frame block those behind it."""
_STRANGERS_S = 0.03
_ATTEMPTS = 5


@dataclass(frozen=True, slots=True)
class OpenStream:
    """An open stream that no buffers have been lent to yet."""

    stream: Any
    method: str
    """`socket` or `packet socket`."""
    buffer_bytes: int
    """What the kernel granted; 0 where it is not a socket's."""
    warning: str | None = None
    """What to tell where the room is too small for a receiver that is held up."""


def open_stream(camera: Any) -> OpenStream | None:
    """Open the stream of an Aravis camera; None where it gives none.  May raise GLib.Error."""
    if not camera.is_gv_device():
        stream = camera.create_stream(None, None)
        return None if stream is None else OpenStream(stream, "memory", 0)
    opened = _open_plain(camera)
    if opened is None or opened.buffer_bytes >= _ENOUGH_BYTES:
        return opened
    if not _may_open_packet_socket():
        return replace(opened, warning=_too_small(opened.buffer_bytes))
    del opened  # one stream at a time
    return _open_packet_socket(camera)


def _may_open_packet_socket() -> bool:
    try:
        socket.socket(socket.AF_PACKET, socket.SOCK_RAW).close()
    except OSError:
        # Without the right to it EPERM; EAFNOSUPPORT where the service's unit forbids the family.
        return False
    return True


def _too_small(buffer_bytes: int) -> str:
    return (
        f"the system lets {buffer_bytes / 1e6:.2f} MB of packets wait and "
        f"{_ENOUGH_BYTES / 1e6:.0f} MB are wanted: frames will be lost when this host is busy; "
        f"sysctl -w net.core.rmem_max={_ENOUGH_BYTES}"
    )


def _open_plain(camera: Any) -> OpenStream | None:
    stream = _create(camera, Aravis.GvStreamOption.PACKET_SOCKET_DISABLED, _PLAIN_RETENTION_US)
    if stream is None:
        return None
    return OpenStream(stream, "socket", enlarge_receive_buffer(stream.get_port()))


def _open_packet_socket(camera: Any) -> OpenStream | None:
    """Open it such that no packets of strangers came in, if that can be had."""
    for _ in range(_ATTEMPTS):
        stream = _create(camera, Aravis.GvStreamOption.NONE, _PACKET_SOCKET_RETENTION_US)
        if stream is None:
            return None
        # Without the right to a packet socket this is a plain one again.
        stream.set_property("socket-buffer", Aravis.GvStreamSocketBuffer.AUTO)
        time.sleep(_STRANGERS_S)
        if stream.get_info_uint64_by_name("n_received_packets") == 0:
            break
    return OpenStream(stream, "packet socket", 0)


def _create(camera: Any, options: Any, retention_us: int) -> Any:
    camera.gv_set_stream_options(options)
    stream = camera.create_stream(None, None)
    if stream is not None:
        stream.set_property("frame-retention", retention_us)
        stream.set_property("packet-request-ratio", _REQUEST_RATIO)
    return stream


def enlarge_receive_buffer(port: int) -> int:
    """Give the UDP socket bound to `port` in this process a large buffer; return its size, bytes.

    The kernel counts its own bookkeeping too: a packet of 9000 bytes takes about 16 kB of it.

    Raises
    ------
    LookupError
        If no socket of this process is bound to it.
    """
    for name in os.listdir("/proc/self/fd"):
        with contextlib.suppress(OSError):  # the listing's own is gone by now
            if not stat.S_ISSOCK(os.fstat(int(name)).st_mode):
                continue
            with socket.socket(fileno=os.dup(int(name))) as candidate:
                if _is_bound_to(candidate, port):
                    return _enlarged(candidate)
    raise LookupError(f"no UDP socket of this process is bound to port {port}")


def _is_bound_to(candidate: socket.socket, port: int) -> bool:
    datagrams = (candidate.family, candidate.type) == (socket.AF_INET, socket.SOCK_DGRAM)
    return datagrams and candidate.getsockname()[1] == port


def _enlarged(stream_socket: socket.socket) -> int:
    try:
        stream_socket.setsockopt(socket.SOL_SOCKET, _SO_RCVBUFFORCE, _WANTED_BYTES)
    except PermissionError:
        stream_socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _WANTED_BYTES)
    return stream_socket.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)
