"""Pictures of wheels that go by, as a camera in free run sees them, and recordings of the same."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from calib import Picture
from station.recording import RecordingWriter
from station.scenes import WheelScene, WheelTruth, paper_sensor, trackside_mounting
from station.simulated import ArraySource

RATE_HZ = 53.7
FRAMES_A_WHEEL = 27
"""From one wheel to the next: 18 km/h where axles are 2.5 m apart."""
_OFFSETS_MM = (-24.0, -2.0, 20.0)
_WHEELS = 4
_LIT = len(_OFFSETS_MM)
_DARK_LEVEL, _DARK_SIGMA = 8.0, 2.0
_START_NS = 1_760_000_000_000_000_000


@dataclass(frozen=True, slots=True)
class WheelsGoingBy:
    """Makes the source of a simulated camera, in the process that serves it.

    Wheel after wheel, each in three pictures, and in between what a camera sees when there is
    none: those pictures are taken, sent, recorded and searched as well.
    """

    path: Path

    def __call__(self) -> ArraySource:
        pictures = np.load(self.path, mmap_mode="r")
        between = [pictures[-1]] * (FRAMES_A_WHEEL - _LIT)
        return ArraySource([
            picture
            for wheel in range(_WHEELS)
            for picture in [*pictures[_LIT * wheel : _LIT * (wheel + 1)], *between]
        ])


def render_wheels(path: Path) -> WheelsGoingBy:
    """Render some wheels, and the dark between them, into a file."""
    rng = np.random.default_rng(1)
    lit = [
        WheelScene(
            paper_sensor(),
            trackside_mounting("left"),
            WheelTruth(tread_wear_mm=1.5 * wheel),
            axle_offset_mm=offset_mm,
            seed=wheel,
        ).render(rng)
        for wheel in range(_WHEELS)
        for offset_mm in _OFFSETS_MM
    ]
    dark = rng.normal(_DARK_LEVEL, _DARK_SIGMA, lit[0].shape).clip(0, 255).astype(np.uint8)
    np.save(path, np.stack([*lit, dark]))
    return WheelsGoingBy(path)


def record_train(path: Path, pictures_path: Path, *, sensor: str, wheels: int) -> int:
    """Record a train whose wheels triggered the camera; return the number of frames."""
    pictures: list[Picture] = list(np.load(pictures_path, mmap_mode="r"))[:-1]
    frame_ns = round(1e9 / RATE_HZ)
    count = 0
    path.parent.mkdir(parents=True, exist_ok=True)
    with RecordingWriter(path) as writer:
        for wheel in range(wheels):
            for shot in range(_LIT):
                picture = pictures[(_LIT * wheel + shot) % len(pictures)]
                time_ns = _START_NS + (wheel * FRAMES_A_WHEEL + shot) * frame_ns
                height, width = picture.shape
                count += 1
                writer.write_frame(
                    sensor, count, time_ns, time_ns, picture.data.cast("B"), width, height
                )
    return count
