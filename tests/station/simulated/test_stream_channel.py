"""What the stream channel sends, seen by a plain socket: packets again, gone ones, test packets."""

import socket
import struct
import time
from ipaddress import IPv4Address

import numpy as np
import pytest

from station.simulated.counters import Statistics
from station.simulated.faults import FaultInjector, Faults
from station.simulated.gvcp import ResendRequest
from station.simulated.gvsp import BlockHeader, Region
from station.simulated.stream import StreamChannel

REGION = Region(64, 48)
PACKETS = 2 + 6  # leader, trailer, and 3072 bytes in pieces of 540
ADDRESS = IPv4Address("127.10.9.1")


class Bench:
    """A stream channel that sends to a socket."""

    def __init__(self):
        self.counters = Statistics()
        self.channel = StreamChannel(
            ADDRESS, FaultInjector(Faults()), self.counters, resend_frames=2
        )
        self.receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.receiver.bind((str(ADDRESS), 0))
        self.receiver.setblocking(False)
        self.channel.connect(ADDRESS, self.receiver.getsockname()[1])

    def send(self, block_id, value=0, **how):
        picture = np.full((REGION.height, REGION.width), value, np.uint8)
        header = BlockHeader(block_id, 0, REGION)
        return self.channel.send_frame(
            header, picture, **{"packet_bytes": 576, "delay_ns": 0} | how
        )

    def received(self):
        packets = []
        while True:
            try:
                packets.append(self.receiver.recv(65536))
            except BlockingIOError:
                return packets

    def ask(self, block_id, first, last):
        """Return (status, packet id) of what comes for a resend request."""
        self.received()
        self.channel.send_again(ResendRequest(block_id, first, last))
        heads = [struct.unpack(">HHI", packet[:8]) for packet in self.received()]
        assert all(head[1] == block_id for head in heads)
        return [(head[0], head[2] & 0xFFFFFF) for head in heads]


@pytest.fixture
def bench():
    bench = Bench()
    yield bench
    bench.channel.close()
    bench.receiver.close()


def test_the_packets_asked_for_are_sent_again_and_no_others(bench):
    bench.send(1)
    assert bench.ask(1, 2, 4) == [(0x0100, 2), (0x0100, 3), (0x0100, 4)]


def test_a_request_for_all_that_follow_ends_with_the_picture(bench):
    bench.send(1)
    assert bench.ask(1, PACKETS - 2, 0xFFFFFF) == [(0x0100, PACKETS - 2), (0x0100, PACKETS - 1)]
    assert bench.ask(1, PACKETS, 0xFFFFFF) == []


def test_of_a_picture_that_is_gone_each_packet_is_said_to_be_unavailable(bench):
    for block_id in (1, 2, 3):
        bench.send(block_id)
    assert bench.ask(1, 2, 3) == [(0x800C, 2), (0x800C, 3)]
    assert bench.ask(1, 2, 0xFFFFFF) == [(0x800C, 2)]
    assert bench.ask(2, 0, 0) == [(0x0100, 0)]
    assert bench.counters.unavailable_packets == 3


def test_forgotten_pictures_are_gone(bench):
    bench.send(1)
    bench.channel.forget()
    assert bench.ask(1, 0, 0) == [(0x800C, 0)]


def test_a_picture_of_another_layout_gets_memory_of_its_own(bench):
    bench.send(1)
    bench.send(2, packet_bytes=1500)
    bench.send(3, value=9)
    *_, last, _trailer = bench.received()
    assert set(last[8:]) == {9}


@pytest.mark.parametrize("packet_bytes", [576, 9000])
def test_a_test_packet_has_the_size_asked_for(bench, packet_bytes):
    bench.channel.send_test_packet(packet_bytes)
    assert [len(packet) + 28 for packet in bench.received()] == [packet_bytes]


def test_without_a_receiver_nothing_is_sent(bench):
    bench.channel.connect(ADDRESS, 0)
    assert not bench.send(1)
    bench.channel.send_test_packet(576)
    assert bench.received() == []


def test_a_receiver_that_has_gone_does_not_stop_the_camera(bench):
    bench.receiver.close()
    bench.receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    assert all(bench.send(block_id) for block_id in (1, 2, 3))


def test_packets_are_spaced_by_the_delay_asked_for(bench):
    begun_s = time.monotonic()
    bench.send(1, packet_bytes=46, delay_ns=1_000_000)  # 308 packets, a millisecond each
    assert time.monotonic() - begun_s >= 0.3
