"""The largest packets that the way from the camera carries, tried before frames depend on it.

A switch without jumbo frames drops every packet of 9000 bytes and says nothing: the camera
answers, and not one frame comes.
"""

from collections.abc import Callable
from dataclasses import dataclass

_USUAL = (9000, 8228, 4088, 1500, 1440, 1400, 576)
"""Jumbo frames, what some drivers and switches make of them, Ethernet, tunnels, the least."""


@dataclass(frozen=True, slots=True)
class PacketSize:
    """The packet size in use, bytes with IP and UDP headers."""

    asked: int
    used: int
    proved: bool
    """A test packet of the size used came; a camera that sends none proves nothing."""

    @property
    def warning(self) -> str | None:
        """What to tell where it is not as asked."""
        if self.used < self.asked:
            return (
                f"packets of {self.asked} bytes do not come through, {self.used} are used: turn on "
                f"jumbo frames in switch and interface, or set packet_size = {self.used}"
            )
        if not self.proved:
            return (
                f"the camera sends no test packets, so packets of {self.asked} bytes are not "
                "proved; if no frame comes, set packet_size = 1500"
            )
        return None


def fitting(asked: int, carries: Callable[[int], bool]) -> PacketSize:
    """Return the size to use: the one asked, or the next usual one that comes through.

    Examples
    --------
    >>> fitting(9000, lambda size: size <= 1500).used
    1500
    >>> fitting(9000, lambda size: False)
    PacketSize(asked=9000, used=9000, proved=False)
    """
    for size in (asked, *(usual for usual in _USUAL if usual < asked)):
        if carries(size):
            return PacketSize(asked, size, proved=True)
    return PacketSize(asked, asked, proved=False)
