"""What the capture processes count and measure, asked when Prometheus asks."""

from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor

from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily, Metric
from prometheus_client.registry import Collector

from station.capture import CaptureStatus
from station.errors import StationError
from station.operations import Capture, Station

_Read = Callable[[CaptureStatus], float | None]


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
        "station_ring_waiting",
        "Of them, those that wait to be written.",
        lambda status: float(status.ring_waiting),
    ),
    (
        "station_clock_offset_seconds",
        "What is added to the camera's time to have UTC.",
        _clock("clock_offset_ns", 1e-9),
    ),
    (
        "station_clock_drift_ppm",
        "By how much the camera's clock runs fast.",
        _clock("clock_drift_ppm", 1.0),
    ),
    (
        "station_clock_residual_seconds",
        "Median distance of the clock's samples from their line.",
        _clock("clock_residual_us", 1e-6),
    ),
)
"""A sensor that records nothing at present has no clock values."""


class CaptureCollector(Collector):
    """Asks every capture process for its status; one that does not answer is down."""

    def __init__(self, station: Station) -> None:
        self._captures = station.captures

    def collect(self) -> Iterable[Metric]:
        statuses = self._statuses()
        up = GaugeMetricFamily(
            "station_sensor_up", "Whether the sensor's camera is open.", labels=["sensor"]
        )
        for sensor, status in statuses.items():
            up.add_metric([sensor], float(status is not None and status.problem is None))
        yield up
        known = {sensor: status for sensor, status in statuses.items() if status is not None}
        yield _totals(known)
        for name, text, read in _GAUGES:
            family = GaugeMetricFamily(name, text, labels=["sensor"])
            for sensor, status in known.items():
                value = read(status)
                if value is not None:
                    family.add_metric([sensor], value)
            yield family

    def _statuses(self) -> dict[str, CaptureStatus | None]:
        # All at a time: each that is down costs the seconds that a starting one is waited for.
        with ThreadPoolExecutor(max_workers=max(1, len(self._captures))) as pool:
            return dict(
                zip(self._captures, pool.map(_status, self._captures.values()), strict=True)
            )


def _status(capture: Capture) -> CaptureStatus | None:
    try:
        return capture.status()
    except StationError:
        return None


def _totals(statuses: dict[str, CaptureStatus]) -> CounterMetricFamily:
    family = CounterMetricFamily(
        "station_capture",
        "Frames by fate, and packets resent, since the sensor's capture process began.",
        labels=["sensor", "what"],
    )
    for sensor, status in statuses.items():
        for what, count in status.totals.items():
            family.add_metric([sensor, what], count)
    return family
