"""Families of metrics from plain values."""

from collections.abc import Iterable, Mapping, Sequence

from prometheus_client.core import CounterMetricFamily, GaugeMetricFamily

Values = Mapping[tuple[str, ...], float]
"""Values by their labels' values."""


def gauges(name: str, text: str, labels: Sequence[str], values: Values) -> GaugeMetricFamily:
    """Return a family of gauges; one without a value is still described."""
    family = GaugeMetricFamily(name, text, labels=labels)
    for label_values, value in values.items():
        family.add_metric(label_values, value)
    return family


def gauge(name: str, text: str, value: float | None) -> GaugeMetricFamily:
    """Return a gauge without labels; None where nobody knows its value."""
    return gauges(name, text, [], {} if value is None else {(): value})


def counters(name: str, text: str, labels: Sequence[str], values: Values) -> CounterMetricFamily:
    """Return a family of counters; `_total` is put behind its name."""
    family = CounterMetricFamily(name, text, labels=labels)
    for label_values, value in values.items():
        family.add_metric(label_values, value)
    return family


def by_sensor(values: Iterable[tuple[str, float | None]]) -> Values:
    """Return the values that are known, by sensor."""
    return {(sensor,): value for sensor, value in values if value is not None}
