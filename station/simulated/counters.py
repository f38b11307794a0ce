"""What a simulated camera has done so far."""

from dataclasses import dataclass, replace


@dataclass(slots=True)
class Statistics:
    """Counts since the device started; each is written by one thread alone.

    Attributes
    ----------
    exposed
        Pictures taken.
    sent
        Pictures of which at least one packet went out.
    lost_frames
        Pictures of which nothing went out: injected, frozen, or no receiver named.
    missed_triggers
        Triggers that came while the camera did not wait for them.
    dropped_packets, duplicated_packets
        Injected, at the first sending.
    resend_requests, resent_packets, dropped_resends, unavailable_packets
        What receivers asked for again: requests, packets sent, dropped again, gone already.
    """

    exposed: int = 0
    sent: int = 0
    lost_frames: int = 0
    missed_triggers: int = 0
    dropped_packets: int = 0
    duplicated_packets: int = 0
    resend_requests: int = 0
    resent_packets: int = 0
    dropped_resends: int = 0
    unavailable_packets: int = 0

    def snapshot(self, *, exposed: int, missed_triggers: int) -> "Statistics":
        """Return a copy that stays as it is, with what the acquisition counts itself."""
        return replace(self, exposed=exposed, missed_triggers=missed_triggers)
