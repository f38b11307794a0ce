"""Rendered pictures of the paper's target and cylinder, and what is seen in them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from calib import (
    CalibError,
    FloatArray,
    LaserSensor,
    StripePoints,
    Target,
    View,
    locate_stripe,
    observe_target,
)
from station.pipeline import map_on_all_cores
from station.scenes import CylinderScene, Light, TargetScene, cylinder_poses, target_scenes

TARGET = Target.parse("dots:7x8:12:d=6")
RADIUS_MM = 30.0
BAD_LIGHTS = tuple(light for light in Light if light is not Light.GOOD)
_RENDER_AND_OBSERVE_S = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class SeenTarget:
    """A target, and what was seen of it."""

    scene: TargetScene
    view: View


@dataclass(frozen=True, slots=True, eq=False)
class SeenCylinder:
    """All ridges in a picture of a cylinder, and the true direction of its axis."""

    stripe: StripePoints
    axis_in_cam: FloatArray
    name: str


def see_targets(
    sensor: LaserSensor, lights: Sequence[Light], count: int, seed: Sequence[int]
) -> list[SeenTarget]:
    """Render `count` targets, the lights in turn, and return those in which the target is seen."""
    rng = np.random.default_rng(seed)
    scenes = target_scenes(rng, sensor, TARGET, _in_turn(lights, count))
    tasks = [(scene, [*seed, place]) for place, scene in enumerate(scenes)]
    views: Iterator[View | None] = map_on_all_cores(
        _see_target, tasks, count=count, seconds_each=_RENDER_AND_OBSERVE_S
    )
    return [
        SeenTarget(scene, view)
        for scene, view in zip(scenes, views, strict=True)
        if view is not None
    ]


def see_cylinders(
    sensor: LaserSensor, lights: Sequence[Light], count: int, seed: Sequence[int]
) -> list[SeenCylinder]:
    """Render `count` cylinders, the lights in turn, and return the ridges in the pictures."""
    poses = cylinder_poses(np.random.default_rng(seed), count, sensor, radius_mm=RADIUS_MM)
    scenes = [
        CylinderScene(sensor, pose, radius_mm=RADIUS_MM, light=light, seed=place)
        for place, (pose, light) in enumerate(zip(poses, _in_turn(lights, count), strict=True))
    ]
    tasks = [(scene, [*seed, place]) for place, scene in enumerate(scenes)]
    stripes: Iterator[StripePoints] = map_on_all_cores(
        _see_cylinder, tasks, count=count, seconds_each=_RENDER_AND_OBSERVE_S
    )
    return [
        SeenCylinder(stripe, scene.cam_from_cylinder.rotation[:, 2], f"{scene.light}-{place}")
        for place, (scene, stripe) in enumerate(zip(scenes, stripes, strict=True))
    ]


def _in_turn(lights: Sequence[Light], count: int) -> list[Light]:
    return [lights[place % len(lights)] for place in range(count)]


def _see_target(task: tuple[TargetScene, list[int]]) -> View | None:
    scene, seed = task
    try:
        return observe_target(
            scene.render(np.random.default_rng(seed)),
            scene.target,
            name=f"{scene.light}-{seed[-1]}",
        )
    except CalibError:
        return None


def _see_cylinder(task: tuple[CylinderScene, list[int]]) -> StripePoints:
    scene, seed = task
    return locate_stripe(scene.render(np.random.default_rng(seed)))
