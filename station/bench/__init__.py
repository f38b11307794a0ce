"""The figures of the README, measured where they are asked for."""

from collections.abc import Callable, Sequence

from station.bench.calibration import bench_solvers, bench_solving
from station.bench.capture import CAPTURE_PARTS, capture_benches
from station.bench.deviations import bench_deviations
from station.bench.lights import bench_lights
from station.bench.pairs import bench_pairs
from station.bench.paper import bench_paper
from station.bench.pose_sets import bench_pose_sets
from station.bench.stripe import bench_stripe, bench_stripe_sigma
from station.bench.sweeps import bench_sweeps
from station.progress import Progress
from station.tables import Table

BENCHES: dict[str, Sequence[Callable[[Progress], Table]]] = {
    "capture": capture_benches(),
    "lights": (bench_lights,),
    "pairs": (bench_pairs,),
    "paper": (bench_paper,),
    "deviations": (bench_deviations,),
    "calibration": (bench_sweeps, bench_pose_sets, bench_solving, bench_solvers),
    "stripe": (bench_stripe, bench_stripe_sigma),
}
"""What `station bench NAME` measures: one table each."""

__all__ = [
    "BENCHES",
    "CAPTURE_PARTS",
    "bench_deviations",
    "bench_lights",
    "bench_pairs",
    "bench_paper",
    "bench_pose_sets",
    "bench_solvers",
    "bench_solving",
    "bench_stripe",
    "bench_stripe_sigma",
    "bench_sweeps",
    "capture_benches",
]
