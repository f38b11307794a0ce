"""What a simulated camera is to look at, as `station camera simulate` is told."""

from dataclasses import dataclass
from pathlib import Path

from station.errors import InputUnusable
from station.progress import Progress
from station.scenes import Light
from station.simulated import (
    FrameSource,
    PictureFolder,
    RecordingSource,
    SceneKind,
    render_scenes,
)


@dataclass(frozen=True, slots=True)
class Playing:
    """How a recording is to be played, if one is."""

    path: Path | None
    sensor: str | None
    once: bool
    rate_hz: float | None

    def __post_init__(self) -> None:
        if self.path is None and (self.sensor or self.once or self.rate_hz):
            raise InputUnusable(
                "--sensor, --once and --rate say how to play; give --from FILE.mcap"
            )

    @property
    def pace(self) -> str:
        """How fast it is played, in words."""
        return f"{self.rate_hz:g} pictures a second" if self.rate_hz else "its own timing"

    def open(self) -> RecordingSource | None:
        """Open the recording, if one is to be played."""
        if self.path is None:
            return None
        return RecordingSource(self.path, self.sensor, once=self.once, rate_hz=self.rate_hz)


@dataclass(frozen=True, slots=True)
class View:
    """What the camera is to look at: one of pictures, a recording, rendered scenes."""

    scene: SceneKind | None
    light: Light
    seed: int
    pictures: Path | None
    playing: Playing
    frames_per_scene: int

    def __post_init__(self) -> None:
        given = [self.scene, self.pictures, self.playing.path]
        if len(given) - given.count(None) > 1:
            raise InputUnusable("a camera looks at one thing: --scene, --pictures or --from")

    @property
    def name(self) -> str:
        """What it is, in words."""
        if self.pictures or self.playing.path:
            return f"from {self.pictures or self.playing.path}"
        return f"{self.scene or SceneKind.TARGET} in {self.light} light"

    @property
    def pace(self) -> str | None:
        """How fast a recording is played, in words; None where none is."""
        return self.playing.pace if self.playing.path else None

    def open(self, progress: Progress) -> FrameSource:
        """Open the pictures or the recording, or render the scenes, which takes seconds."""
        if self.pictures:
            return PictureFolder(self.pictures)
        played = self.playing.open()
        if played is not None:
            return played
        kind = self.scene or SceneKind.TARGET
        return render_scenes(
            kind,
            self.light,
            seed=self.seed,
            progress=progress,
            frames_per_scene=self.frames_per_scene,
        )
