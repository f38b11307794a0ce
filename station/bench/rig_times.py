"""How long a rig takes: its solve, and joining what two sensors see of one wheel."""

from collections.abc import Callable

import numpy as np

from calib import calibrate_rig
from measure import Shot, Survey, WheelFrame, measure_wheel_on_rig, reference_profile
from measure.laying.by_axle import Unmeasured, lay_by_axle
from measure.laying.section import SheetPoints
from measure.merging.merged import merge
from measure.placing.template import template_of
from station.bench.figures import Row, below
from station.bench.rig_pictures import ANCHOR, BOARD_SIGMA_MM, SHOWINGS, BuiltRig
from station.bench.timing import CoreTime
from station.pipeline import locate_wheel_stripe
from station.progress import Progress
from station.scenes import Light, WheelTruth
from station.tables import Table

_RUNS = 9
_ASKED_SOLVE_S, _ASKED_MERGE_MS = 1.0, 10.0
_USUAL_SHOT_MS = 50.0
_WHEEL = WheelTruth(tread_wear_mm=3.0, flange_wear_mm=1.5)


def bench_rig_times(progress: Progress, *, seed: int = 1) -> Table:
    """Time the solve of a rig from rendered showings, and a rendered wheel before it.

    Parameters
    ----------
    progress
        Told where the bench is.
    seed
        Of pictures.
    """
    progress(0.0, "rendering showings")
    built = BuiltRig.from_pictures([Light.GOOD], seed)
    progress(0.8, "timing")
    scenes = built.truth.shot(_WHEEL, axle_offset_mm=15.0, seed=seed)
    shot = Shot(
        tuple(
            WheelFrame(
                locate_wheel_stripe(scene.render(np.random.default_rng([seed, place]))),
                0,
                "rendered",
                sensor=name,
            )
            for place, (name, scene) in enumerate(scenes.items())
        )
    )
    reference, survey = reference_profile(_WHEEL.reference), Survey()

    def solve() -> object:
        return calibrate_rig(
            built.showings,
            built.sensors,
            built.boards,
            anchor=ANCHOR,
            sigma_board_mm=BOARD_SIGMA_MM,
        )

    def measure() -> object:
        return measure_wheel_on_rig([shot], built.found, survey, reference)

    rows = [
        _row(f"solving a rig from {SHOWINGS} showings", solve, "s", _ASKED_SOLVE_S),
        _row("joining two sensors' sections", _merging(shot, built), "ms", _ASKED_MERGE_MS),
        _row("a shot of two sensors, stripes to readings", measure, "ms", _USUAL_SHOT_MS),
    ]
    note = f"Time of one core: median of {_RUNS} runs, and how far half of them lie apart."
    return Table("Time of a rig", rows, (note,))


def _row(what: str, work: Callable[[], object], unit: str, asked: float) -> Row:
    took, per_s = CoreTime.of(work, runs=_RUNS), {"s": 1.0, "ms": 1e3}[unit]
    spread = f"{took.spread_s * per_s:.2g}"
    return below(what, [took.median_s * per_s], asked, unit) | {"spread": spread}


def _merging(shot: Shot, built: BuiltRig) -> Callable[[], object]:
    """Return what joins the sections of a shot that is laid over the reference."""
    rig, survey = built.found, Survey()
    template = template_of(reference_profile(_WHEEL.reference))
    sheets = {
        frame.sensor: SheetPoints.of(frame.stripe, rig[frame.sensor].sensor)
        for frame in shot.frames
    }
    laying = lay_by_axle(sheets, rig, survey, template)
    if isinstance(laying, Unmeasured):
        raise TypeError(f"the rendered wheel could not be laid: {laying.reason}")
    return lambda: merge(laying, rig, survey, template)
