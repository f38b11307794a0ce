"""What the running station reaches: its store, its API under load, its processes when killed."""

from station.bench.service.kills import bench_service_kills
from station.bench.service.load import bench_service
from station.bench.service.store import bench_service_store
from station.bench.service.viewed import bench_service_viewed

__all__ = ["bench_service", "bench_service_kills", "bench_service_store", "bench_service_viewed"]
