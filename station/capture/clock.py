"""The camera's clock and UTC."""

from enum import StrEnum

_SYNCHRONISED_WITHIN_NS = 3600 * 1_000_000_000


class ClockSource(StrEnum):
    """Where a frame's time comes from; it stands in the camera's record."""

    CAMERA_UTC = "camera"
    """The camera keeps UTC (PTP)."""
    CAMERA_OFFSET = "camera, offset by its first frame"
    """The camera counts from its start; the first frame's reception ties it to UTC."""
    HOST = "host"
    """The camera has no clock: times are those of reception."""


class CameraClock:
    """Maps a camera's timestamps to UTC, ns; the first frame decides how."""

    def __init__(self, tick_frequency_hz: int) -> None:
        # Without a tick frequency Aravis silently puts the host's time in its place.
        self.source: ClockSource | None = None if tick_frequency_hz > 0 else ClockSource.HOST
        self._offset_ns = 0

    def utc_ns(self, camera_ns: int, received_ns: int) -> int:
        """Return the UTC time of a frame stamped `camera_ns` and received at `received_ns`."""
        if self.source is None:
            self._decide(camera_ns, received_ns)
        if self.source is ClockSource.HOST:
            return received_ns
        return camera_ns + self._offset_ns

    def _decide(self, camera_ns: int, received_ns: int) -> None:
        if abs(camera_ns - received_ns) <= _SYNCHRONISED_WITHIN_NS:
            self.source = ClockSource.CAMERA_UTC
        else:
            self.source = ClockSource.CAMERA_OFFSET
            self._offset_ns = received_ns - camera_ns
