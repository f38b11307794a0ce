"""Room in the kernel for packets that wait while the receiver is held up.

Aravis offers two ways to receive, and neither is right as it comes:

- Its packet socket (AF_PACKET, needs CAP_NET_RAW) takes packets of *every* stream on the host until
  its filter is set, and mistakes the block id of the first for its own: armed while another camera
  streams, it discards up to a hundred of the first frames as late.  Its ring also holds only 80 ms.
- Its plain socket has whatever buffer the kernel grants, by default a tenth of a frame.  Aravis can
  ask for one frame's worth, which is 19 ms.

So the plain socket is used, and given a buffer by the rights of a station: CAP_NET_ADMIN lets it
have any size, otherwise ``net.core.rmem_max`` is the limit.
"""

import contextlib
import os
import socket

_WANTED_BYTES = 64 << 20
_SO_RCVBUFFORCE = 33  # Linux; the module `socket` does not name it


def enlarge_receive_buffer(port: int) -> int:
    """Give the UDP socket bound to `port` in this process a large buffer; return its size, bytes.

    The kernel counts its own bookkeeping too: a packet of 9000 bytes takes about 16 kB of it.
    """
    for name in os.listdir("/proc/self/fd"):
        with contextlib.suppress(OSError), socket.socket(fileno=os.dup(int(name))) as candidate:
            if candidate.type == socket.SOCK_DGRAM and candidate.getsockname()[1] == port:
                return _enlarged(candidate)
    raise LookupError(f"no UDP socket of this process is bound to port {port}")


def _enlarged(stream_socket: socket.socket) -> int:
    try:
        stream_socket.setsockopt(socket.SOL_SOCKET, _SO_RCVBUFFORCE, _WANTED_BYTES)
    except PermissionError:
        stream_socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _WANTED_BYTES)
    return stream_socket.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)
