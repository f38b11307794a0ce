"""What can go wrong between a camera and its receiver, at will and repeatably."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

MAX_DELAY_S = 1.0  # the pictures on their way must fit into memory
LARGEST_PACKET_BYTES = 65_535
_REACH = 8  # a late packet is overtaken by at most so many others


@dataclass(frozen=True, slots=True)
class Faults:
    """Which faults the link has; none by default.

    Attributes
    ----------
    packet_loss, packet_duplication, packet_reorder
        Probability that a packet is dropped, sent twice, or overtaken by up to eight others.
        Packets sent again on request are dropped with the same probability.
    frame_loss
        Probability that nothing of a picture is sent. Its block id is used up all the same.
    lost_frames
        Pictures of which nothing is sent, counted in exposures since the device started, from 0.
    delay_s
        Time from the end of an exposure to its first packet, s.
    path_bytes
        Packets larger than this, with their IP and UDP headers, do not arrive: a switch on the way
        has a smaller MTU.
    seed
        Same seed, same faults.
    """

    packet_loss: float = 0.0
    packet_duplication: float = 0.0
    packet_reorder: float = 0.0
    frame_loss: float = 0.0
    lost_frames: frozenset[int] = frozenset()
    delay_s: float = 0.0
    path_bytes: int = LARGEST_PACKET_BYTES
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("packet_loss", "packet_duplication", "packet_reorder", "frame_loss"):
            value = getattr(self, name)
            if not (0.0 <= value <= 1.0):
                raise ValueError(f"{name} must be a probability, 0 to 1, got {value}")
        if not (0.0 <= self.delay_s <= MAX_DELAY_S):
            raise ValueError(f"delay_s must be 0 to {MAX_DELAY_S} s, got {self.delay_s}")
        if not (68 <= self.path_bytes <= LARGEST_PACKET_BYTES):
            raise ValueError(
                f"path_bytes must be 68 to {LARGEST_PACKET_BYTES}, got {self.path_bytes}"
            )
        if not (self.seed >= 0):
            raise ValueError(f"seed must not be negative, got {self.seed}")


class FaultInjector:
    """Draws the faults of one device, picture after picture."""

    def __init__(self, faults: Faults) -> None:
        self._faults = faults
        self._rng = np.random.default_rng([faults.seed, 0])
        # Requests come from another thread in their own order: a generator of their own keeps
        # the faults of the pictures repeatable.
        self._resend_rng = np.random.default_rng([faults.seed, 1])

    def loses_frame(self, index: int) -> bool:
        """Return whether nothing is sent of the exposure `index`."""
        drawn = self._faults.frame_loss > 0.0 and self._rng.random() < self._faults.frame_loss
        return bool(drawn) or index in self._faults.lost_frames

    def transmission(self, count: int) -> Sequence[int]:
        """Return which of a picture's `count` packets are sent, in the order of sending."""
        faults = self._faults
        if not (faults.packet_loss or faults.packet_duplication or faults.packet_reorder):
            return range(count)
        kept = np.flatnonzero(self._rng.random(count) >= faults.packet_loss)
        twice = self._rng.random(len(kept)) < faults.packet_duplication
        packets = np.repeat(kept, 1 + twice)
        late = self._rng.random(len(packets)) < faults.packet_reorder
        lateness = late * self._rng.uniform(1.0, _REACH, len(packets))
        order: list[int] = packets[
            np.argsort(np.arange(len(packets)) + lateness, kind="stable")
        ].tolist()
        return order

    def blocks(self, packet_bytes: int) -> bool:
        """Return whether packets of this size, headers included, do not pass."""
        return packet_bytes > self._faults.path_bytes

    def loses_resent_packet(self) -> bool:
        """Return whether a packet sent again on request is dropped too."""
        loss = self._faults.packet_loss
        return loss > 0.0 and bool(self._resend_rng.random() < loss)
