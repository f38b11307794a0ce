"""What the capture processes count and measure, as of the last look at the station."""

from collections.abc import Callable, Iterable, Mapping

from prometheus_client.core import Metric
from prometheus_client.registry import Collector

from station.api.families import by_sensor, counters, gauges
from station.capture import CaptureStatus
from station.watching import Lookout

_Read = Callable[[CaptureStatus], float | None]
_PACKETS = "resent_packets"


def _clock(name: str, scale: float) -> _Read:
    def read(status: CaptureStatus) -> float | None:
        text = status.clock.get(name, "")
        return float(text) * scale if text else None

    return read


_GAUGES: tuple[tuple[str, str, _Read], ...] = (
    (
        "station_ring_slots",
        "Places between camera and disk.",
        lambda status: float(status.ring_slots),
    ),
    (
        "station_ring_waiting_frames",
        "Of them, those that wait to be written.",
        lambda status: float(status.ring_waiting),
    ),
    (
        "station_sensor_temperature_celsius",
        "Temperature of the camera while it recorded nothing, where it tells.",
        lambda status: status.temperature_c,
    ),
    (
        "station_clock_offset_seconds",
        "What is added to the camera's time to have UTC.",
        _clock("clock_offset_ns", 1e-9),
    ),
    (
        "station_clock_drift_ratio",
        "By which part the camera's clock runs fast.",
        _clock("clock_drift_ppm", 1e-6),
    ),
    (
        "station_clock_residual_seconds",
        "Median distance of the clock's samples from their line.",
        _clock("clock_residual_us", 1e-6),
    ),
)
"""A sensor that records nothing at present has no clock values."""


class CaptureCollector(Collector):
    """Tells what the capture processes that answer said last; one that does not is down."""

    def __init__(self, lookout: Lookout, sensors: Iterable[str]) -> None:
        self._lookout = lookout
        self._sensors = tuple(sensors)

    def collect(self) -> Iterable[Metric]:
        statuses = self._lookout.look().statuses
        up = {
            sensor: sensor in statuses and statuses[sensor].problem is None
            for sensor in self._sensors
        }
        yield gauges(
            "station_sensor_up",
            "Whether the sensor's camera is open.",
            ["sensor"],
            by_sensor((sensor, float(is_up)) for sensor, is_up in up.items()),
        )
        yield counters(
            "station_sensor_frames",
            "Frames by fate, since the sensor's capture process began.",
            ["sensor", "fate"],
            _frames(statuses),
        )
        yield counters(
            "station_sensor_packets_resent",
            "Packets that were lost and sent again, since the sensor's capture process began.",
            ["sensor"],
            by_sensor((sensor, each.totals.get(_PACKETS)) for sensor, each in statuses.items()),
        )
        for name, text, read in _GAUGES:
            values = ((sensor, read(status)) for sensor, status in statuses.items())
            yield gauges(name, text, ["sensor"], by_sensor(values))


def _frames(statuses: Mapping[str, CaptureStatus]) -> dict[tuple[str, ...], float]:
    return {
        (sensor, fate): float(count)
        for sensor, status in statuses.items()
        for fate, count in status.totals.items()
        if fate != _PACKETS
    }
