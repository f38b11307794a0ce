"""The light plane in good light and in the six bad ones, by every method, beside the truth."""

from collections.abc import Sequence

import numpy as np

from calib import (
    CalibError,
    Calibration,
    LaserSensor,
    Method,
    Picture,
    Target,
    View,
    calibrate,
    observe_target,
    sheet_difference_mm,
)
from station.demo import working_field_px
from station.pipeline import map_on_all_cores
from station.progress import Progress
from station.scenes import Light, TargetScene, paper_sensor, target_scenes
from station.tables import Table, Value

TARGET = Target.parse("dots:7x8:12:d=6")
_RENDER_AND_OBSERVE_S = 0.3
SceneTask = tuple[TargetScene, int, str]
"""A scene, the seed of its noise, and the picture's name."""


def bench_lights(progress: Progress, *, poses: int = 20, seed: int = 1) -> Table:
    """Calibrate from rendered pictures of each light, the camera known.

    Parameters
    ----------
    progress
        Told where the bench is.
    poses
        Pictures a light.
    seed
        Of poses and noise.
    """
    sensor = paper_sensor()
    rows: list[dict[str, Value]] = []
    for done, light in enumerate(Light):
        progress(done / len(Light), light.value)
        views, unseen = observe_light(light, sensor, poses=poses, seed=seed)
        row: dict[str, Value] = {"light": light.value, "target not seen": unseen}
        for method in Method:
            error_mm = sheet_error_mm(views, sensor, method)
            row[f"{method} sheet error, mm RMS"] = error_mm if np.isfinite(error_mm) else "refused"
        rows.append(row)
    note = (
        f"{poses} poses a light of {TARGET}, camera known, seed {seed}; RMS over the field at "
        "working distance of how far a point on the sheet is placed wrongly."
    )
    return Table("Light plane by light", rows, (note,))


def observe_light(
    light: Light, sensor: LaserSensor, *, poses: int, seed: int
) -> tuple[list[View], int]:
    """Render and observe pictures in one light; return what was seen and how many were not."""
    rng = np.random.default_rng([seed, list(Light).index(light)])
    scenes = target_scenes(rng, sensor, TARGET, [light] * poses)
    seen = observe_scenes([(scene, n, f"{light}-{n:02d}") for n, scene in enumerate(scenes)])
    views = [view for view in seen if view is not None]
    return views, len(seen) - len(views)


def observe_scenes(tasks: Sequence[SceneTask]) -> list[View | None]:
    """Render scenes and observe their targets, on all cores; None where one was not found."""
    return list(
        map_on_all_cores(_observe, tasks, count=len(tasks), seconds_each=_RENDER_AND_OBSERVE_S)
    )


def _observe(task: SceneTask) -> View | None:
    scene, noise_seed, name = task
    picture: Picture = scene.render(np.random.default_rng(noise_seed))
    try:
        return observe_target(picture, scene.target, name=name)
    except CalibError:
        return None


def sheet_error_mm(views: list[View], truth: LaserSensor, method: Method) -> float:
    """Root mean square error of the sheet over the field, by one method; NaN where it refuses."""
    camera = truth.camera
    try:
        answer: Calibration = calibrate(
            views, TARGET, width=camera.width, height=camera.height, camera=camera, method=method
        )
    except CalibError:
        return float("nan")
    difference = sheet_difference_mm(answer.sensor, truth, working_field_px(truth))
    return float(np.sqrt(np.nanmean(difference**2)))
