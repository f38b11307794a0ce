"""The control channel: who may command the device, and what each command is answered."""

import time
from collections.abc import Callable
from typing import Protocol

from station.simulated import gvcp
from station.simulated import registers as reg
from station.simulated.gvcp import Acknowledge, Command, MalformedPacket, Request, Status
from station.simulated.identity import DISCOVERY_BYTES
from station.simulated.memory import CameraMemory, Refused

Sender = tuple[str, int]


class Effects(Protocol):
    """What a device does when it is commanded."""

    def register_written(self, register: reg.Register, value: int) -> None:
        """Obey a write of `value`, the first word of what was written."""

    def resend_requested(self, request: gvcp.ResendRequest) -> None:
        """Send packets again."""

    def control_lost(self) -> None:
        """Fall silent: nobody controls the device any more."""


class ControlChannel:
    """Answers GVCP datagrams; knows no socket.

    One client at a time controls the device, from the moment it writes CCP until it releases
    it or is silent for a heartbeat timeout. In control mode others may read, in exclusive mode
    only CCP itself.
    """

    def __init__(
        self,
        memory: CameraMemory,
        effects: Effects,
        *,
        monotonic_s: Callable[[], float] = time.monotonic,
    ) -> None:
        self._memory = memory
        self._effects = effects
        self._monotonic_s = monotonic_s
        self._controller: Sender | None = None
        self._heard_s = 0.0
        self._last_write: tuple[Sender, bytes, bytes] | None = None
        self._handlers: dict[int, Callable[[bytes, Sender], bytes]] = {
            Command.DISCOVERY: lambda _payload, _sender: self.discovery_payload(),
            Command.READ_REGISTER: self._read_registers,
            Command.WRITE_REGISTER: self._write_registers,
            Command.READ_MEMORY: self._read_memory,
            Command.WRITE_MEMORY: self._write_memory,
        }

    def discovery_payload(self) -> bytes:
        """Return what the device says of itself: the beginning of its registers."""
        return self._memory.beginning(DISCOVERY_BYTES)

    def seconds_to_expiry(self) -> float | None:
        """Return when the controller's time runs out, or None where nobody controls."""
        if self._controller is None:
            return None
        timeout_s = self._memory.get(reg.HEARTBEAT_TIMEOUT) * 1e-3
        return self._heard_s + timeout_s - self._monotonic_s()

    def oust(self, holder: Sender) -> None:
        """Give control to another client, as after a silence in which that one asked for it."""
        self._release()
        self._memory.put(reg.CONTROL_PRIVILEGE, reg.Privilege.CONTROL)
        self._controller = holder
        self._heard_s = self._monotonic_s()

    def expire(self) -> None:
        """Take control from a client that has been silent too long."""
        left_s = self.seconds_to_expiry()
        if left_s is not None and left_s <= 0.0:
            self._release()

    def handle(self, datagram: bytes, sender: Sender) -> bytes | None:
        """Carry out a command and return the answer, or None where none is due."""
        self.expire()
        try:
            request = Request.decode(datagram)
        except MalformedPacket:
            return None
        if sender == self._controller:
            self._heard_s = self._monotonic_s()
        if request.command == Command.PACKET_RESEND:
            self._request_resend(request.payload, sender)
            return None
        return self._answer(request, datagram, sender)

    def _answer(self, request: Request, datagram: bytes, sender: Sender) -> bytes | None:
        writes = request.command in {Command.WRITE_REGISTER, Command.WRITE_MEMORY}
        # A client that missed the answer repeats the command under the same request id: it is
        # answered again, not carried out again, or one software trigger would become two.
        if writes and self._last_write and self._last_write[:2] == (sender, datagram):
            return self._last_write[2]
        status, payload = self._carry_out(request, sender)
        answer = Acknowledge(status, request.command, request.request_id, payload).encode()
        if writes:
            self._last_write = (sender, datagram, answer)
        return answer if request.wants_acknowledge else None

    def _carry_out(self, request: Request, sender: Sender) -> tuple[Status, bytes]:
        handler = self._handlers.get(request.command)
        if handler is None:
            return Status.NOT_IMPLEMENTED, b""
        try:
            return Status.SUCCESS, handler(request.payload, sender)
        except Refused as refusal:
            return refusal.status, refusal.payload
        except MalformedPacket:
            return Status.INVALID_PARAMETER, b""

    def _read_registers(self, payload: bytes, sender: Sender) -> bytes:
        values = b""
        for address in gvcp.decode_addresses(payload):
            try:
                self._check_may_read(address, sender)
                values += self._memory.read(address, 4)
            except Refused as refusal:
                raise Refused(refusal.status, values) from None
        return values

    def _write_registers(self, payload: bytes, sender: Sender) -> bytes:
        writes = gvcp.decode_writes(payload)
        for done, (address, value) in enumerate(writes):
            try:
                self._write(address, value.to_bytes(4, "big"), sender)
            except Refused as refusal:
                raise Refused(refusal.status, gvcp.encode_index(done)) from None
        return gvcp.encode_index(len(writes))

    def _read_memory(self, payload: bytes, sender: Sender) -> bytes:
        address, count = gvcp.decode_memory_read(payload)
        self._check_may_read(address, sender)
        return payload[:4] + self._memory.read(address, count)

    def _write_memory(self, payload: bytes, sender: Sender) -> bytes:
        address, data = gvcp.decode_memory_write(payload)
        try:
            self._write(address, data, sender)
        except Refused as refusal:
            raise Refused(refusal.status, gvcp.encode_index(0)) from None
        return gvcp.encode_index(len(data))

    def _write(self, address: int, data: bytes, sender: Sender) -> None:
        wanted = int.from_bytes(data[:4], "big")
        if address == reg.CONTROL_PRIVILEGE.address:
            self._write_privilege(wanted, data, sender)
            return
        if sender != self._controller:
            raise Refused(Status.ACCESS_DENIED)
        register = self._memory.write(address, data)
        self._effects.register_written(register, wanted)

    def _write_privilege(self, wanted: int, data: bytes, sender: Sender) -> None:
        if self._controller not in {None, sender}:
            raise Refused(Status.ACCESS_DENIED)
        self._memory.write(reg.CONTROL_PRIVILEGE.address, data)
        if wanted:
            self._controller = sender
            self._heard_s = self._monotonic_s()
        elif self._controller is not None:
            self._release()

    def _check_may_read(self, address: int, sender: Sender) -> None:
        exclusive = self._memory.get(reg.CONTROL_PRIVILEGE) & reg.Privilege.EXCLUSIVE
        privilege_itself = address == reg.CONTROL_PRIVILEGE.address
        if exclusive and sender != self._controller and not privilege_itself:
            raise Refused(Status.ACCESS_DENIED)

    def _request_resend(self, payload: bytes, sender: Sender) -> None:
        # It comes from the controller's stream socket: the same host, another port.
        if self._controller is None or sender[0] != self._controller[0]:
            return
        try:
            self._effects.resend_requested(gvcp.ResendRequest.decode(payload))
        except MalformedPacket:
            return

    def _release(self) -> None:
        self._controller = None
        self._memory.put(reg.CONTROL_PRIVILEGE, reg.Privilege.OPEN)
        self._effects.control_lost()
