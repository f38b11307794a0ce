"""Rendering what a camera stands before."""

from typing import TYPE_CHECKING

from station.progress import Progress, silent
from station.simulated.scene_kind import SceneKind
from station.simulated.sources import FrameSource

if TYPE_CHECKING:
    from station.scenes import Light


def render_scenes(
    kind: SceneKind,
    light: "Light",
    *,
    seed: int = 0,
    progress: Progress = silent,
    frames_per_scene: int = 1,
) -> FrameSource:
    """Render a dozen scenes of a kind as the paper's sensor sees them.

    Targets and cylinders stand in poses drawn from `seed`. Wheels are worn as drawn, and each is
    seen three times while it rolls through the sheet. Each scene stands for `frames_per_scene`
    pictures: as long as an exposure sequence takes.
    """
    # The renderer takes half a second to import: only a camera before a scene pays for it.
    from station.simulated.scene_source import render_dozen  # noqa: PLC0415

    return render_dozen(kind, light, seed, progress, frames_per_scene)
