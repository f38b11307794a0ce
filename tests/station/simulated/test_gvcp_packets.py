"""Control packets survive the way to bytes and back; what is no packet is refused by name."""

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from station.simulated import gvcp
from station.simulated.gvcp import Acknowledge, MalformedPacket, Request, ResendRequest

WORDS = st.integers(0, 0xFFFF_FFFF)
HALVES = st.integers(0, 0xFFFF)
IDS = st.integers(1, 0xFFFF)
PACKET_IDS = st.integers(0, 0xFF_FFFF)


@given(HALVES, IDS, st.binary(max_size=600), st.booleans())
def test_a_command_decodes_to_itself(command, request_id, payload, wants_acknowledge):
    request = Request(command, request_id, payload, wants_acknowledge)
    assert Request.decode(request.encode()) == request


@given(HALVES, HALVES, HALVES, st.binary(max_size=600))
def test_an_acknowledge_decodes_to_itself(status, command, request_id, payload):
    answer = Acknowledge(status, command, request_id, payload)
    assert Acknowledge.decode(answer.encode()) == answer


@given(HALVES, PACKET_IDS, PACKET_IDS)
def test_a_resend_request_decodes_to_itself(block_id, first, last):
    request = ResendRequest(block_id, first, last)
    assert ResendRequest.decode(request.encode()) == request


@given(st.lists(WORDS, min_size=1, max_size=130))
def test_addresses_decode_to_themselves(addresses):
    assert gvcp.decode_addresses(gvcp.encode_addresses(addresses)) == addresses


@given(st.lists(st.tuples(WORDS, WORDS), min_size=1, max_size=65))
def test_register_writes_decode_to_themselves(writes):
    assert gvcp.decode_writes(gvcp.encode_writes(writes)) == writes


@given(WORDS, HALVES)
def test_a_memory_read_decodes_to_itself(address, count):
    assert gvcp.decode_memory_read(gvcp.encode_memory_read(address, count)) == (address, count)


@given(WORDS, st.binary(min_size=4, max_size=536))
def test_a_memory_write_decodes_to_itself(address, data):
    assert gvcp.decode_memory_write(gvcp.encode_memory_write(address, data)) == (address, data)


def test_the_bytes_of_a_read_of_ccp_are_those_of_the_specification():
    request = Request(gvcp.Command.READ_REGISTER, 7, gvcp.encode_addresses([0x0A00]))
    assert request.encode() == bytes.fromhex("42 01 0080 0004 0007 00000a00".replace(" ", ""))


@given(st.binary(max_size=40))
def test_random_bytes_are_a_packet_or_are_refused(datagram):
    for decode in (Request.decode, Acknowledge.decode, ResendRequest.decode):
        try:
            decode(datagram)
        except MalformedPacket:
            continue


@pytest.mark.parametrize(
    "datagram",
    [
        b"",
        b"\x42\x01\x00\x02\x00\x00\x00",  # a byte short of a header
        b"\x43\x01\x00\x02\x00\x00\x00\x01",  # another protocol's key
        b"\x42\x01\x00\x02\x00\x04\x00\x01",  # four bytes announced, none there
        b"\x42\x01\x00\x02\x00\x00\x00\x00",  # request id 0 is reserved
    ],
)
def test_what_is_no_command_is_refused(datagram):
    with pytest.raises(MalformedPacket):
        Request.decode(datagram)


@pytest.mark.parametrize("size", [0, 1, 3, 6])
def test_payloads_of_a_wrong_length_are_refused(size):
    payload = b"\0" * size
    for decode in (
        gvcp.decode_addresses,
        gvcp.decode_writes,
        gvcp.decode_memory_read,
        gvcp.decode_memory_write,
    ):
        with pytest.raises(MalformedPacket):
            decode(payload)


def test_an_acknowledge_carries_the_number_of_its_command_plus_one():
    _status, code, _length, _id = struct.unpack(">HHHH", Acknowledge(0, 0x80, 1).encode())
    assert code == 0x81
