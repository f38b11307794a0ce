"""What the last look at the station found, for Prometheus."""

from collections import Counter
from collections.abc import Iterable

from prometheus_client.core import Metric
from prometheus_client.registry import Collector

from station.api.families import gauge, gauges
from station.software import SOFTWARE
from station.watching import Condition, Lookout


class WatchingCollector(Collector):
    """Tells what `/readyz` and the alarms of `/v1/station` tell, of the same look."""

    def __init__(self, lookout: Lookout, name: str) -> None:
        self._lookout = lookout
        self._name = name

    def collect(self) -> Iterable[Metric]:
        outlook = self._lookout.look()
        yield gauges(
            "station_info",
            "1; its labels name the station and its software.",
            ["name", "software"],
            {(self._name, SOFTWARE): 1.0},
        )
        yield gauge(
            "station_ready",
            "Whether the next train will be recorded and measured.",
            float(outlook.ready),
        )
        yield gauges(
            "station_part_condition",
            "1 for the condition that a part of the station is in.",
            ["part", "condition"],
            {
                (part, condition.value): float(outlook.part(part).condition is condition)
                for part in outlook.parts
                for condition in Condition
            },
        )
        alarms = Counter((each.kind.value, each.severity.value) for each in outlook.troubles)
        yield gauges(
            "station_alarms",
            "What somebody should look at, by kind; `/v1/station` says what and since when.",
            ["kind", "severity"],
            {labels: float(count) for labels, count in alarms.items()},
        )
