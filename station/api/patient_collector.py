"""Collecting from parts of which each may fail or hang, and none keeps the others from telling."""

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from threading import Lock

import structlog
from prometheus_client.core import CounterMetricFamily, Metric
from prometheus_client.registry import Collector

from station.watching import Asker, answers_of

_PATIENCE_S = 3.0
"""Prometheus itself gives up after 10 s, and would then have nothing."""
_log = structlog.get_logger()


class PatientCollector(Collector):
    """Asks its parts at a time, waits 3 s at most, and counts those that did not tell."""

    def __init__(self, parts: Mapping[str, Collector], *, patience_s: float = _PATIENCE_S) -> None:
        self._askers = {
            name: Asker(f"collect {name}", partial(_collected, part))
            for name, part in parts.items()
        }
        self._patience_s = patience_s
        self._errors = dict.fromkeys(parts, 0)
        # Two who collect would take each other's answers.
        self._collecting = Lock()

    def collect(self) -> Iterable[Metric]:
        with self._collecting:
            found = answers_of(self._askers, self._patience_s)
            for name, answer in found.items():
                if not isinstance(answer, list):
                    self._note(name, answer)
            return [metric for answer in found.values() for metric in _metrics(answer)] + [
                self._family()
            ]

    def _note(self, part: str, answer: Exception | None) -> None:
        self._errors[part] += 1
        why = f"no answer within {self._patience_s:g} s" if answer is None else repr(answer)
        _log.warning("metrics not collected", part=part, why=why)

    def _family(self) -> CounterMetricFamily:
        family = CounterMetricFamily(
            "station_collect_errors",
            "Times that a part of these metrics could not be collected, and is missing here.",
            labels=["part"],
        )
        for part, count in self._errors.items():
            family.add_metric([part], count)
        return family


def _collected(part: Collector) -> list[Metric]:
    return list(part.collect())


def _metrics(answer: object) -> Sequence[Metric]:
    return answer if isinstance(answer, list) else []
