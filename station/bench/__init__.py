"""The figures of the README, measured where they are asked for."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

from station.bench.calibration import bench_solvers, bench_solving
from station.bench.capture import CAPTURE_PARTS, capture_benches
from station.bench.deviations import bench_deviations
from station.bench.drawing import Drawing
from station.bench.lights import bench_lights
from station.bench.measure import bench_oblique, bench_wheels
from station.bench.measure_intervals import bench_intervals
from station.bench.measure_lights import bench_measure_lights
from station.bench.measure_profiles import bench_profiles
from station.bench.measure_rolling import bench_rolling
from station.bench.measure_train import bench_train
from station.bench.page import bench_page
from station.bench.pairs import bench_pairs
from station.bench.paper import bench_paper
from station.bench.paper_draws import bench_paper_draws
from station.bench.piece import bench_piece
from station.bench.piece_u95 import bench_piece_u95
from station.bench.pose_sets import bench_pose_sets
from station.bench.replay_many import bench_replay_many
from station.bench.rig_calibration import bench_rig_calibration
from station.bench.rig_intervals import bench_rig_intervals
from station.bench.rig_times import bench_rig_times
from station.bench.rig_wheels import bench_rig_wheels
from station.bench.service import (
    bench_service,
    bench_service_kills,
    bench_service_store,
    bench_service_viewed,
)
from station.bench.stripe import bench_stripe, bench_stripe_sigma
from station.bench.sweeps import bench_sweeps
from station.progress import Progress
from station.tables import Table


def measure_benches(folder: Path | None = None) -> Sequence[Callable[[Progress], Table]]:
    """Return the benches of wheel readings; `folder` holds MiniProf files of real wheels."""
    return (
        bench_wheels,
        bench_oblique,
        bench_rolling,
        partial(bench_profiles, folder=folder),
        bench_intervals,
        bench_measure_lights,
        bench_train,
    )


BENCHES: dict[str, Sequence[Callable[[Progress], Table]]] = {
    "capture": capture_benches(),
    "lights": (bench_lights,),
    "measure": measure_benches(),
    "page": (bench_page,),
    "pairs": (bench_pairs,),
    "paper": (bench_paper,),
    "piece": (bench_piece, bench_piece_u95),
    "deviations": (bench_deviations,),
    "replay": (bench_replay_many,),
    "rig": (bench_rig_wheels, bench_rig_intervals, bench_rig_times),
    "rig-calibration": (bench_rig_calibration,),
    "calibration": (bench_sweeps, bench_pose_sets, bench_solving, bench_solvers),
    "service": (bench_service,),
    "service-kills": (bench_service_kills,),
    "service-store": (bench_service_store,),
    "service-viewed": (bench_service_viewed,),
    "stripe": (bench_stripe, bench_stripe_sigma),
}
"""What `station bench NAME` measures: one table each."""

DRAWN: dict[str, Sequence[Callable[..., Table]]] = {
    "calibration": (bench_sweeps, bench_pose_sets),
    "measure": (bench_intervals,),
    "paper": (bench_paper_draws,),
    "piece": (bench_piece_u95,),
    "rig": (bench_rig_intervals,),
}
"""Those that are many draws of a simulation: they take who does the draws, as a `Drawing`."""

__all__ = [
    "BENCHES",
    "CAPTURE_PARTS",
    "DRAWN",
    "Drawing",
    "bench_deviations",
    "bench_lights",
    "bench_intervals",
    "bench_measure_lights",
    "bench_oblique",
    "bench_page",
    "bench_pairs",
    "bench_paper",
    "bench_paper_draws",
    "bench_piece",
    "bench_piece_u95",
    "bench_pose_sets",
    "bench_profiles",
    "bench_replay_many",
    "bench_rig_calibration",
    "bench_rig_intervals",
    "bench_rig_times",
    "bench_rig_wheels",
    "bench_rolling",
    "bench_service",
    "bench_service_kills",
    "bench_service_store",
    "bench_service_viewed",
    "bench_solvers",
    "bench_solving",
    "bench_stripe",
    "bench_stripe_sigma",
    "bench_sweeps",
    "bench_train",
    "bench_wheels",
    "capture_benches",
    "measure_benches",
]
