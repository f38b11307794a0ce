"""Who may command the device, for how long, and what a wrong command is answered.

Without sockets: datagrams go in, answers come out, and the clock is the test's own.
"""

import struct
from ipaddress import IPv4Address

import pytest

from station.simulated import gvcp
from station.simulated import registers as reg
from station.simulated.control import ControlChannel
from station.simulated.gvcp import Acknowledge, Command, Request, Status
from station.simulated.identity import Identity
from station.simulated.memory import CameraMemory

ONE, OTHER = ("127.0.0.1", 5000), ("127.0.0.1", 6000)
IDENTITY = Identity(IPv4Address("127.10.1.1"), "Maker", "Model", "1.0", "S1")


class Recorder:
    """Notes what the device was told to do."""

    def __init__(self):
        self.done = []

    def register_written(self, register, value):
        self.done.append((register.address, value))

    def resend_requested(self, request):
        self.done.append(request)

    def control_lost(self):
        self.done.append("control lost")


class Bench:
    """A control channel, its clock, and a client's way to talk to it."""

    def __init__(self):
        self.now_s = 100.0
        self.effects = Recorder()
        self.memory = CameraMemory(IDENTITY, 640, 480, 53.0)
        self.channel = ControlChannel(self.memory, self.effects, monotonic_s=lambda: self.now_s)
        self._request_id = 0

    def ask(self, sender, command, payload=b"", *, again=False):
        self._request_id += not again
        datagram = Request(command, self._request_id, payload).encode()
        answer = Acknowledge.decode(self.channel.handle(datagram, sender))
        assert (answer.command, answer.request_id) == (command, self._request_id)
        return answer

    def write(self, sender, address, value, **how):
        payload = gvcp.encode_writes([(address, value)])
        return self.ask(sender, Command.WRITE_REGISTER, payload, **how).status

    def read(self, sender, address):
        return self.ask(sender, Command.READ_REGISTER, gvcp.encode_addresses([address]))

    def take_control(self, sender, privilege=reg.Privilege.CONTROL):
        return self.write(sender, reg.CONTROL_PRIVILEGE.address, privilege)


@pytest.fixture
def bench():
    return Bench()


@pytest.fixture
def controlled(bench):
    bench.take_control(ONE)
    return bench


def test_discovery_tells_who_the_device_is(bench):
    assert Identity.from_discovery(bench.ask(ONE, Command.DISCOVERY).payload) == IDENTITY


def test_without_control_nothing_is_written(bench):
    assert bench.write(ONE, reg.WIDTH.address, 320) == Status.ACCESS_DENIED
    assert bench.memory.get(reg.WIDTH) == 640


def test_a_second_client_gets_no_control(controlled):
    assert controlled.take_control(OTHER) == Status.ACCESS_DENIED
    assert controlled.write(OTHER, reg.WIDTH.address, 320) == Status.ACCESS_DENIED
    assert controlled.write(ONE, reg.WIDTH.address, 320) == Status.SUCCESS


def test_under_control_others_may_read(controlled):
    assert controlled.read(OTHER, reg.WIDTH.address).status == Status.SUCCESS


def test_under_exclusive_control_others_read_nothing_but_the_privilege(bench):
    bench.take_control(ONE, reg.Privilege.EXCLUSIVE)
    assert bench.read(OTHER, reg.WIDTH.address).status == Status.ACCESS_DENIED
    assert bench.read(OTHER, reg.CONTROL_PRIVILEGE.address).payload == b"\0\0\0\1"
    assert bench.read(ONE, reg.WIDTH.address).status == Status.SUCCESS


def test_released_control_can_be_taken_by_another(controlled):
    controlled.take_control(ONE, reg.Privilege.OPEN)
    assert controlled.effects.done == ["control lost"]
    assert controlled.take_control(OTHER) == Status.SUCCESS


def test_a_silent_controller_loses_control_after_its_heartbeat_timeout(controlled):
    controlled.now_s += 2.9
    assert controlled.take_control(OTHER) == Status.ACCESS_DENIED
    controlled.now_s += 0.2
    assert controlled.take_control(OTHER) == Status.SUCCESS
    assert controlled.write(ONE, reg.WIDTH.address, 320) == Status.ACCESS_DENIED
    assert "control lost" in controlled.effects.done


def test_any_command_of_the_controller_keeps_its_control(controlled):
    for _ in range(5):
        controlled.now_s += 2.9
        controlled.read(ONE, reg.CONTROL_PRIVILEGE.address)
    assert controlled.take_control(OTHER) == Status.ACCESS_DENIED


def test_the_heartbeat_timeout_can_be_chosen(controlled):
    controlled.write(ONE, reg.HEARTBEAT_TIMEOUT.address, 500)
    controlled.now_s += 0.6
    controlled.channel.expire()
    assert controlled.effects.done[-1] == "control lost"
    assert controlled.channel.seconds_to_expiry() is None


@pytest.mark.parametrize(
    ("address", "status"),
    [
        (0xA300, Status.INVALID_ADDRESS),
        (0xFFFF_FFFC, Status.INVALID_ADDRESS),
        (0xA009, Status.BAD_ALIGNMENT),
    ],
)
def test_a_read_from_a_wrong_place_says_what_is_wrong(bench, address, status):
    assert bench.read(ONE, address).status == status


@pytest.mark.parametrize(
    ("address", "value", "status"),
    [
        (0xA300, 1, Status.INVALID_ADDRESS),
        (reg.XML_ADDRESS, 1, Status.WRITE_PROTECT),
        (reg.PAYLOAD_SIZE.address, 1, Status.WRITE_PROTECT),
        (reg.VERSION.address, 1, Status.WRITE_PROTECT),
        (reg.WIDTH.address, 641, Status.INVALID_PARAMETER),
        (reg.WIDTH.address, 8, Status.INVALID_PARAMETER),
        (reg.OFFSET_X.address, 1, Status.INVALID_PARAMETER),
        (reg.PIXEL_FORMAT.address, 0x01100003, Status.INVALID_PARAMETER),
        (reg.TRIGGER_SOURCE.address, 2, Status.INVALID_PARAMETER),
        (reg.STREAM_PACKET_SIZE.address, 9001, Status.INVALID_PARAMETER),
        (reg.STREAM_PACKET_SIZE.address, 100, Status.INVALID_PARAMETER),
        (reg.HEARTBEAT_TIMEOUT.address, 100, Status.INVALID_PARAMETER),
        (reg.CONTROL_PRIVILEGE.address, 4, Status.INVALID_PARAMETER),
        (reg.EXPOSURE_TIME.address, 1, Status.INVALID_PARAMETER),  # half of an 8-byte register
        (0xA00A, 1, Status.BAD_ALIGNMENT),
    ],
)
def test_a_wrong_write_says_what_is_wrong_and_changes_nothing(controlled, address, value, status):
    before = bytes(controlled.memory._bytes)
    assert controlled.write(ONE, address, value) == status
    assert bytes(controlled.memory._bytes) == before
    assert controlled.effects.done == []


@pytest.mark.parametrize("exposure_us", [9.0, 1e7, float("nan"), float("inf")])
def test_an_exposure_out_of_range_is_refused(controlled, exposure_us):
    data = struct.pack(">d", exposure_us)
    answer = controlled.ask(
        ONE, Command.WRITE_MEMORY, gvcp.encode_memory_write(reg.EXPOSURE_TIME.address, data)
    )
    assert answer.status == Status.INVALID_PARAMETER
    assert controlled.memory.get_real(reg.EXPOSURE_TIME) == reg.DEFAULT_EXPOSURE_US


def test_several_reads_stop_at_the_first_wrong_one(bench):
    wanted = gvcp.encode_addresses([reg.WIDTH.address, 0xA300, reg.HEIGHT.address])
    answer = bench.ask(ONE, Command.READ_REGISTER, wanted)
    assert answer.status == Status.INVALID_ADDRESS
    assert answer.payload == (640).to_bytes(4, "big")


def test_several_writes_stop_at_the_first_wrong_one_and_say_how_many_were_done(controlled):
    writes = [(reg.WIDTH.address, 320), (reg.WIDTH.address, 9999), (reg.HEIGHT.address, 240)]
    answer = controlled.ask(ONE, Command.WRITE_REGISTER, gvcp.encode_writes(writes))
    assert (answer.status, answer.payload) == (Status.INVALID_PARAMETER, gvcp.encode_index(1))
    assert controlled.memory.get(reg.HEIGHT) == 480


def test_a_command_repeated_under_its_id_is_answered_again_but_done_once(controlled):
    controlled.write(ONE, reg.TRIGGER_SOFTWARE.address, 1)
    again = controlled.write(ONE, reg.TRIGGER_SOFTWARE.address, 1, again=True)
    assert again == Status.SUCCESS
    assert controlled.effects.done == [(reg.TRIGGER_SOFTWARE.address, 1)]


def test_an_unknown_command_is_not_implemented(bench):
    assert bench.ask(ONE, 0x0100).status == Status.NOT_IMPLEMENTED


def test_a_payload_that_makes_no_sense_is_an_invalid_parameter(bench):
    assert bench.ask(ONE, Command.READ_REGISTER, b"\0\0").status == Status.INVALID_PARAMETER
    assert bench.ask(ONE, Command.READ_MEMORY, b"").status == Status.INVALID_PARAMETER


@pytest.mark.parametrize(
    ("address", "count", "status"),
    [
        (reg.XML_ADDRESS, 540, Status.INVALID_PARAMETER),
        (reg.XML_ADDRESS, 0, Status.INVALID_PARAMETER),
        (reg.XML_ADDRESS, 6, Status.BAD_ALIGNMENT),
        (0xA200, 8, Status.INVALID_ADDRESS),  # runs beyond the last register
    ],
)
def test_a_memory_read_of_a_wrong_piece_says_what_is_wrong(bench, address, count, status):
    payload = gvcp.encode_memory_read(address, count)
    assert bench.ask(ONE, Command.READ_MEMORY, payload).status == status


@pytest.mark.parametrize("datagram", [b"", b"hello, camera", b"\x42" * 8])
def test_noise_is_not_answered(bench, datagram):
    assert bench.channel.handle(datagram, ONE) is None


def test_a_command_that_wants_no_answer_gets_none_and_is_done(controlled):
    payload = gvcp.encode_writes([(reg.WIDTH.address, 320)])
    request = Request(Command.WRITE_REGISTER, 99, payload, wants_acknowledge=False)
    assert controlled.channel.handle(request.encode(), ONE) is None
    assert controlled.memory.get(reg.WIDTH) == 320


def test_packets_are_sent_again_for_the_controllers_host_alone(controlled):
    wanted = gvcp.ResendRequest(3, 1, 4)
    datagram = Request(Command.PACKET_RESEND, 1, wanted.encode(), False).encode()
    assert controlled.channel.handle(datagram, ("127.0.0.9", 5000)) is None
    assert controlled.effects.done == []
    # The stream socket of the controller asks: same host, another port.
    assert controlled.channel.handle(datagram, (ONE[0], 7777)) is None
    assert controlled.effects.done == [wanted]


def test_the_region_and_the_payload_size_go_together(controlled):
    for register, value in ((reg.WIDTH, 320), (reg.OFFSET_X, 320), (reg.HEIGHT, 100)):
        assert controlled.write(ONE, register.address, value) == Status.SUCCESS
    assert controlled.memory.get(reg.PAYLOAD_SIZE) == 32_000
    assert controlled.write(ONE, reg.WIDTH.address, 321) == Status.INVALID_PARAMETER


@pytest.mark.parametrize("lock", ["acquiring", "locked by the client"])
def test_the_layout_of_pictures_is_fixed_while_they_are_taken(controlled, lock):
    if lock == "acquiring":
        controlled.memory.is_acquiring = lambda: True
    else:
        controlled.write(ONE, reg.TL_PARAMS_LOCKED.address, 1)
    assert controlled.write(ONE, reg.WIDTH.address, 320) == Status.BUSY
    assert controlled.write(ONE, reg.TRIGGER_MODE.address, 1) == Status.SUCCESS


def test_a_name_given_by_the_user_is_kept_and_found(controlled):
    data = gvcp.encode_memory_write(reg.USER_NAME.address, b"left side 2\0")
    assert controlled.ask(ONE, Command.WRITE_MEMORY, data).status == Status.SUCCESS
    found = Identity.from_discovery(controlled.ask(OTHER, Command.DISCOVERY).payload)
    assert found.user_name == "left side 2"
