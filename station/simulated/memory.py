"""The memory of the simulated camera: registers with their rules, and the GenICam description."""

import struct
from collections.abc import Callable
from importlib import resources

from station.simulated import registers as reg
from station.simulated.gvcp import MAX_MEMORY_BYTES, Status
from station.simulated.gvsp import MONO8, Region
from station.simulated.identity import Identity

_XML_FILE = "genicam.xml"
_BY_ADDRESS = {register.address: register for register in reg.REGISTERS}


class Refused(Exception):
    """A command the device does not carry out; `status` says why, as GVCP does."""

    def __init__(self, status: Status, payload: bytes = b"") -> None:
        super().__init__(status.name)
        self.status = status
        self.payload = payload


class CameraMemory:
    """Reads and writes by address for clients, by register for the camera itself."""

    def __init__(self, identity: Identity, width: int, height: int, frame_rate_hz: float) -> None:
        xml = resources.files(__package__).joinpath(_XML_FILE).read_bytes()
        padded = xml.ljust(-(-len(xml) // 4) * 4, b"\0")
        self._bytes = bytearray(reg.XML_ADDRESS) + padded
        self._readable = bytearray(reg.XML_ADDRESS) + b"\1" * len(padded)
        for register in reg.REGISTERS:
            end = register.address + register.length
            self._readable[register.address : end] = b"\1" * register.length
        identity.store(self.put_text, self.put)
        self.put_text(reg.FIRST_URL, f"Local:{_XML_FILE};{reg.XML_ADDRESS:x};{len(xml):x}")
        for target, value in _defaults(width, height).items():
            self.put(target, value)
        self.put_real(reg.FRAME_RATE, frame_rate_hz)
        self.put_real(reg.EXPOSURE_TIME, reg.DEFAULT_EXPOSURE_US)
        self.put_real(reg.DEVICE_TEMPERATURE, reg.TEMPERATURE_C)
        self._update_payload_size()
        self.is_acquiring: Callable[[], bool] = lambda: False

    def get(self, register: reg.Register) -> int:
        value: int = struct.unpack_from(">I", self._bytes, register.address)[0]
        return value

    def put(self, register: reg.Register, value: int) -> None:
        struct.pack_into(">I", self._bytes, register.address, value)

    def get_real(self, register: reg.Register) -> float:
        value: float = struct.unpack_from(">d", self._bytes, register.address)[0]
        return value

    def put_real(self, register: reg.Register, value: float) -> None:
        struct.pack_into(">d", self._bytes, register.address, value)

    def put_text(self, register: reg.Register, text: str) -> None:
        # One byte stays 0: readers look for the end of the text.
        data = text.encode()[: register.length - 1].ljust(register.length, b"\0")
        self._bytes[register.address : register.address + register.length] = data

    @property
    def region(self) -> Region:
        """The part of the sensor that is read out."""
        return Region(
            width=self.get(reg.WIDTH),
            height=self.get(reg.HEIGHT),
            offset_x=self.get(reg.OFFSET_X),
            offset_y=self.get(reg.OFFSET_Y),
        )

    @property
    def packet_bytes(self) -> int:
        """GevSCPSPacketSize."""
        return self.get(reg.STREAM_PACKET_SIZE) & reg.SCPS_SIZE_MASK

    def beginning(self, count: int) -> bytes:
        """Return the first `count` bytes; what stands between registers is 0."""
        return bytes(self._bytes[:count])

    def read(self, address: int, count: int) -> bytes:
        """Return `count` bytes from `address` on.

        Raises
        ------
        Refused
            If the place or the length is not a multiple of four, too long, or not all of it exists.
        """
        if address % 4 or count % 4:
            raise Refused(Status.BAD_ALIGNMENT)
        if not (0 < count <= MAX_MEMORY_BYTES):
            raise Refused(Status.INVALID_PARAMETER)
        end = address + count
        if end > len(self._readable) or 0 in self._readable[address:end]:
            raise Refused(Status.INVALID_ADDRESS)
        return bytes(self._bytes[address:end])

    def write(self, address: int, data: bytes) -> reg.Register:
        """Write one register and return it.

        Raises
        ------
        Refused
            If nothing writable begins at `address`, the length is not its length, the value is
            out of range, or it is fixed while pictures are taken.
        """
        if address % 4 or len(data) % 4:
            raise Refused(Status.BAD_ALIGNMENT)
        register = _BY_ADDRESS.get(address)
        if register is None:
            known = address < len(self._readable) and self._readable[address]
            raise Refused(Status.WRITE_PROTECT if known else Status.INVALID_ADDRESS)
        if not register.writable:
            raise Refused(Status.WRITE_PROTECT)
        if register.frames_layout and (self.get(reg.TL_PARAMS_LOCKED) or self.is_acquiring()):
            raise Refused(Status.BUSY)
        if not (self._length_fits(register, data) and self._value_fits(register, data)):
            raise Refused(Status.INVALID_PARAMETER)
        if register not in reg.COMMANDS:
            self._bytes[address : address + register.length] = data.ljust(register.length, b"\0")
            self._update_payload_size()
        return register

    @staticmethod
    def _length_fits(register: reg.Register, data: bytes) -> bool:
        if register.kind is reg.Kind.TEXT:
            return 0 < len(data) <= register.length
        return len(data) == register.length

    def _value_fits(self, register: reg.Register, data: bytes) -> bool:
        if register.kind is reg.Kind.TEXT:
            return True
        value = struct.unpack(">d" if register.kind is reg.Kind.FLOAT64 else ">I", data)[0]
        if register is reg.STREAM_PACKET_SIZE:
            size: int = value & reg.SCPS_SIZE_MASK
            return size % 4 == 0 and reg.MIN_PACKET_BYTES <= size <= reg.MAX_PACKET_BYTES
        return register.allows(value) and self._region_fits(register, value)

    def _region_fits(self, register: reg.Register, value: int) -> bool:
        """Return whether the region would still lie on the sensor, were `register` `value`."""

        def wanted(part: reg.Register) -> int:
            return value if part is register else self.get(part)

        parts = (reg.WIDTH, reg.HEIGHT, reg.OFFSET_X, reg.OFFSET_Y)
        region = Region(*(wanted(part) for part in parts))
        return min(region.width, region.height) >= reg.MIN_REGION_PX and region.fits(
            self.get(reg.WIDTH_MAX), self.get(reg.HEIGHT_MAX)
        )

    def _update_payload_size(self) -> None:
        self.put(reg.PAYLOAD_SIZE, self.region.payload_bytes)


def _defaults(width: int, height: int) -> dict[reg.Register, int]:
    return {
        reg.VERSION: 0x0001_0002,
        reg.DEVICE_MODE: 0x8000_0001,  # big-endian registers, texts in UTF-8
        reg.IP_CONFIG_SUPPORTED: 7,
        reg.IP_CONFIG_CURRENT: 5,
        reg.NETWORK_INTERFACES: 1,
        reg.STREAM_CHANNELS: 1,
        # serial number and user name registers; packet resend, WRITEMEM, several reads at once
        reg.GVCP_CAPABILITY: 0xC000_0007,
        reg.HEARTBEAT_TIMEOUT: reg.DEFAULT_HEARTBEAT_MS,
        reg.TICK_FREQUENCY_LOW: reg.TICKS_PER_SECOND,
        reg.STREAM_PACKET_SIZE: reg.DEFAULT_PACKET_BYTES,
        reg.WIDTH_MAX: width,
        reg.HEIGHT_MAX: height,
        reg.WIDTH: width,
        reg.HEIGHT: height,
        reg.PIXEL_FORMAT: MONO8,
        reg.ACQUISITION_FRAME_COUNT: 1,
        reg.FRAME_RATE_ENABLE: 1,
        reg.USER_OUTPUT: 1,  # the laser shines until it is switched off
    }
