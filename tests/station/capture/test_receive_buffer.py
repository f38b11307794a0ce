"""Room in the kernel for packets, and asking for a camera: small talks with the system."""

import contextlib
import errno
import os
import socket
from pathlib import Path

import pytest
from capture_rig import small_camera

from station.capture import open_stream
from station.capture.open_stream import enlarge_receive_buffer
from station.capture.ping import answers_ping


def buffer_of(udp):
    return udp.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)


def descriptors_of(udp):
    """Return those of this process that are this socket: others come and go with other threads."""
    root = Path("/proc/self/fd")
    name, found = (root / str(udp.fileno())).readlink(), []
    for each in root.iterdir():
        with contextlib.suppress(FileNotFoundError):  # closed since it was listed
            if each.readlink() == name:
                found.append(int(each.name))
    return found


def test_socket_of_a_port_gets_a_larger_buffer_and_no_descriptor_is_left():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        udp.bind(("127.20.5.1", 0))
        before = buffer_of(udp)
        granted = enlarge_receive_buffer(udp.getsockname()[1])
        assert descriptors_of(udp) == [udp.fileno()]
        assert granted == buffer_of(udp) > before


def test_port_that_nobody_is_bound_to_is_an_error():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        udp.bind(("127.20.5.1", 0))
        port = udp.getsockname()[1]
    with pytest.raises(LookupError, match=str(port)):
        enlarge_receive_buffer(port)


@pytest.mark.parametrize("refusal", [errno.EPERM, errno.EAFNOSUPPORT])
def test_who_may_open_no_packet_socket_is_not_offered_one(refusal, monkeypatch):
    """EPERM without CAP_NET_RAW; EAFNOSUPPORT from systemd's RestrictAddressFamilies."""

    def refuse(*_):
        raise OSError(refusal, os.strerror(refusal))

    monkeypatch.setattr(open_stream.socket, "socket", refuse)
    assert not open_stream._may_open_packet_socket()


def test_camera_answers_a_ping_and_silence_does_not():
    with small_camera("127.20.5.2"):
        assert answers_ping("127.20.5.2")
    assert not answers_ping("127.20.5.2")
