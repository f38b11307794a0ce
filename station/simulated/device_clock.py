"""The clock of a simulated camera: right, or wrong in a known way."""

from dataclasses import dataclass

_NEVER_SET_NS = 0


@dataclass(frozen=True, slots=True)
class DeviceClock:
    """What the camera's clock shows at a time of this host.

    Attributes
    ----------
    offset_ns
        What it is ahead of UTC at `since_ns`.
    drift_ppm
        By how much it runs fast from then on.
    since_ns
        UTC, ns: when it was last set.
    ticks
        Whether it says how fast it ticks. A camera without a clock says 0 Hz.
    """

    offset_ns: int = 0
    drift_ppm: float = 0.0
    since_ns: int = _NEVER_SET_NS
    ticks: bool = True

    def __post_init__(self) -> None:
        if not (abs(self.drift_ppm) <= 1000.0):
            raise ValueError(f"drift_ppm must be within 1000, got {self.drift_ppm}")
        if self.drift_ppm and not (self.since_ns > _NEVER_SET_NS):
            raise ValueError("a clock that drifts was set at some time; give since_ns")

    def camera_ns(self, utc_ns: int) -> int:
        """Return what the clock shows at a time.

        Examples
        --------
        >>> DeviceClock(offset_ns=7, drift_ppm=50.0, since_ns=10**9).camera_ns(2 * 10**9)
        2000050007
        """
        return utc_ns + self.offset_ns + round((utc_ns - self.since_ns) * self.drift_ppm * 1e-6)
