"""Who a GigE Vision device says it is when somebody asks."""

import ipaddress
import struct
from collections.abc import Callable
from dataclasses import dataclass
from typing import Self

from station.simulated import registers as reg
from station.simulated.gvcp import MalformedPacket

DISCOVERY_BYTES = 0xF8  # a discovery acknowledge is the beginning of the bootstrap registers


@dataclass(frozen=True, slots=True)
class Identity:
    """The part of a discovery acknowledge that people ask for."""

    address: ipaddress.IPv4Address
    vendor: str
    model: str
    version: str
    serial: str
    user_name: str = ""

    @property
    def mac(self) -> str:
        """A locally administered MAC address, one for each IP address."""
        return ":".join(f"{byte:02x}" for byte in b"\x02\x00" + self.address.packed)

    def store(
        self,
        put_text: Callable[[reg.Register, str], None],
        put: Callable[[reg.Register, int], None],
    ) -> None:
        """Write the identity into a device's bootstrap registers."""
        put_text(reg.VENDOR_NAME, self.vendor)
        put_text(reg.MODEL_NAME, self.model)
        put_text(reg.DEVICE_VERSION, self.version)
        put_text(reg.SERIAL_NUMBER, self.serial)
        put_text(reg.USER_NAME, self.user_name)
        high, low = struct.unpack(">HI", bytes.fromhex(self.mac.replace(":", "")))
        put(reg.MAC_HIGH, high)
        put(reg.MAC_LOW, low)
        put(reg.CURRENT_IP, int(self.address))
        put(reg.CURRENT_SUBNET, 0xFF00_0000)

    @classmethod
    def from_discovery(cls, payload: bytes) -> Self:
        """Read a discovery acknowledge.

        Raises
        ------
        MalformedPacket
            If it is shorter than the specification says.
        """
        if len(payload) < DISCOVERY_BYTES:
            raise MalformedPacket(f"{len(payload)} bytes are no discovery acknowledge")

        def text(register: reg.Register) -> str:
            data = payload[register.address : register.address + register.length]
            return data.split(b"\0")[0].decode(errors="replace")

        (address,) = struct.unpack_from(">I", payload, reg.CURRENT_IP.address)
        return cls(
            address=ipaddress.IPv4Address(address),
            vendor=text(reg.VENDOR_NAME),
            model=text(reg.MODEL_NAME),
            version=text(reg.DEVICE_VERSION),
            serial=text(reg.SERIAL_NUMBER),
            user_name=text(reg.USER_NAME),
        )
