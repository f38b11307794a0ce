"""What the store counts of passes, jobs and wheels, for Prometheus."""

from collections.abc import Iterable, Iterator
from datetime import datetime

from prometheus_client.core import Metric
from prometheus_client.registry import Collector
from sqlalchemy.orm import Session

from station.api.families import Values, gauges
from station.operations import Station
from station.store import Job, Pass
from station.store.watched import (
    counts_by_state,
    frame_totals,
    last_measured_pass,
    queued_jobs,
    wheels_seen,
)


class StoreCollector(Collector):
    """Reads them from the store when they are asked for."""

    def __init__(self, station: Station) -> None:
        self._store = station.store
        self._now = station.now

    def collect(self) -> Iterable[Metric]:
        with self._store.look() as session:
            return [*_passes(session), *_queue(session, self._now()), *_last_pass(session)]


def _passes(session: Session) -> Iterator[Metric]:
    passes = counts_by_state(session, Pass)
    yield gauges("station_passes", "Passes by state.", ["state"], _one_label(passes))
    frames = frame_totals(session)
    yield gauges(
        "station_recorded_frames",
        "Frames of all recordings made here, by fate; they stay counted when deleted.",
        ["sensor", "fate"],
        {labels: float(count) for labels, count in frames.items()},
    )


def _queue(session: Session, now: datetime) -> Iterator[Metric]:
    jobs = counts_by_state(session, Job)
    yield gauges("station_jobs", "Jobs by state.", ["state"], _one_label(jobs))
    queued = queued_jobs(session)
    yield gauges(
        "station_jobs_waiting",
        "Jobs that wait for the worker, by kind.",
        ["kind"],
        {(kind,): float(count) for kind, (count, _) in queued.items()},
    )
    yield gauges(
        "station_jobs_oldest_waiting_seconds",
        "How long the oldest of them has waited.",
        ["kind"],
        {(kind,): (now - oldest).total_seconds() for kind, (_, oldest) in queued.items()},
    )


def _last_pass(session: Session) -> Iterator[Metric]:
    last = last_measured_pass(session)
    seen = {} if last is None else wheels_seen(session, last)
    yield gauges(
        "station_last_pass_wheels",
        "Wheels of the last pass that was measured, by sensor or rig and by what came of them.",
        ["sensor", "outcome"],
        {
            (sensor, outcome): float(count)
            for sensor, wheels in seen.items()
            for outcome, count in (
                ("measured", wheels.measured),
                ("unmeasurable", wheels.unmeasurable),
            )
        },
    )
    yield gauges(
        "station_last_pass_coverage_ratio",
        "How much of the profile was seen on its measured wheels, mean.",
        ["sensor"],
        {
            (sensor,): wheels.coverage
            for sensor, wheels in seen.items()
            if wheels.coverage is not None
        },
    )


def _one_label(values: dict[str, int]) -> Values:
    return {(name,): float(count) for name, count in values.items()}
