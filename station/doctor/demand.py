"""What the cameras will ask of the host: bytes a second, packets, memory."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from station.settings import SensorSettings

_WIDTH_PX, _HEIGHT_PX = 2048, 1088
"""Of the sensor the station is made for; what a camera really sends shows when it is opened."""
_FAKE = "Fake"
_HEADERS_BYTES = 20 + 8 + 8
"""IP, UDP and GVSP, of each packet."""


@dataclass(frozen=True, slots=True)
class Stream:
    """What one camera sends at its highest rate."""

    sensor: str
    address: str
    packet_size: int
    """With IP and UDP headers, as GigE Vision counts."""
    frame_rate_hz: float
    ring_slots: int
    picture_bytes: int = _WIDTH_PX * _HEIGHT_PX

    @classmethod
    def of(cls, sensor: SensorSettings) -> "Stream":
        """Return the stream that a sensor's settings ask for."""
        region = sensor.region
        return cls(
            sensor=sensor.id,
            address=sensor.address,
            packet_size=sensor.packet_size,
            frame_rate_hz=sensor.frame_rate_hz,
            ring_slots=sensor.ring_slots,
            picture_bytes=(region.width_px or _WIDTH_PX) * (region.height_px or _HEIGHT_PX),
        )

    @property
    def on_network(self) -> bool:
        """Whether it comes from an address, and not from the camera that Aravis brings along."""
        return bool(self.address) and not self.address.startswith(_FAKE)

    @property
    def bytes_per_s(self) -> float:
        """Bytes of pictures a second."""
        return self.picture_bytes * self.frame_rate_hz

    @property
    def packets_per_frame(self) -> int:
        """Packets of pixels a frame, with its leader and trailer."""
        return math.ceil(self.picture_bytes / (self.packet_size - _HEADERS_BYTES)) + 2

    @property
    def ring_bytes(self) -> int:
        """Memory that holds frames between camera and disk."""
        return self.ring_slots * self.picture_bytes


def bytes_per_s(streams: Sequence[Stream]) -> float:
    """Bytes a second of all cameras together."""
    return sum(stream.bytes_per_s for stream in streams)
