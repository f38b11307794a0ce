"""Doing one task: from the files of its recordings to wheels."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from station.documents import WheelDocument
from station.errors import StationError
from station.pipeline import (
    Batch,
    Cores,
    RigGauge,
    UnreadBatch,
    WheelGauge,
    measured_on_rig,
    measured_wheels,
    recorded_batches,
)
from station.replay.passes import Lookers, wheels_of_pass
from station.replay.task import ReplayTask
from station.settings import MAX_SKEW_US

Files = Mapping[str, Sequence[Path]]
"""The files of recordings by their names."""


class Measuring:
    """The measuring of one task, and what came of it beside wheels.

    Attributes
    ----------
    refused
        Recordings that turned out to be damaged, and why: their wheels do not count.
    frames
        Those that were read.
    """

    def __init__(
        self,
        lookers: Lookers,
        cores: Cores,
        *,
        max_skew_us: Mapping[str, float],
        frames_done: Callable[[int], None],
    ) -> None:
        self.refused: dict[str, str] = {}
        self.frames = 0
        self._lookers, self._cores, self._max_skew_us = lookers, cores, max_skew_us
        self._told = frames_done

    def wheels(self, task: ReplayTask, files: Files) -> Iterator[WheelDocument]:
        """Yield the wheels; what is yielded of recordings that end up refused is to be dropped."""
        lookers = self._lookers
        if not task.sensors:
            (gauge,) = lookers.gauges.values()
            return self._of_one(files, task.name, gauge)

        def of_one(name: str, gauge: WheelGauge) -> Iterator[WheelDocument]:
            return self._of_one(files, name, gauge)

        def on_rig(chosen: Mapping[str, str], gauge: RigGauge) -> Iterator[WheelDocument]:
            return self._on_rig(files, chosen, gauge)

        return wheels_of_pass(task.one_pass, lookers, self.refused, of_one, on_rig)

    def _of_one(self, files: Files, name: str, gauge: WheelGauge) -> Iterator[WheelDocument]:
        return measured_wheels(
            self._batches(files, name),
            gauge,
            self._cores,
            unread=self._refuse,
            frames_done=self._series(),
        )

    def _on_rig(
        self, files: Files, chosen: Mapping[str, str], gauge: RigGauge
    ) -> Iterator[WheelDocument]:
        return measured_on_rig(
            {sensor: self._batches(files, name) for sensor, name in chosen.items()},
            gauge,
            self._cores,
            max_skew_us=self._max_skew_us.get(gauge.rig_id, MAX_SKEW_US),
            unread=self._refuse,
            frames_done=self._series(),
        )

    def _batches(self, files: Files, name: str) -> Iterator[Batch]:
        """Yield the frames of a recording; of one that turns out to be damaged, no more."""
        try:
            for batch in recorded_batches(files[name], name):
                if name in self.refused:
                    break
                yield batch
        except StationError as error:
            self.refused.setdefault(name, str(error))

    def _refuse(self, unread: UnreadBatch) -> None:
        self.refused.setdefault(unread.source, str(unread.error))

    def _series(self) -> Callable[[int], None]:
        """Return what takes the count of frames of recordings that are measured next."""
        before = self.frames

        def frames_done(count: int) -> None:
            self.frames = before + count
            self._told(self.frames)

        return frames_done
