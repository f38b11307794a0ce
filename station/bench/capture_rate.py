"""Cameras at full rate: what is lost, what differs, what receiver and recorder cost."""

import threading
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from station.bench.capture_rig import Format, Rig, differing
from station.bench.figures import Row, below, figure, none_of
from station.bench.processes import usage_of
from station.capture import CaptureReport, CaptureState
from station.progress import Progress
from station.recording import Rotation, part_path
from station.tables import Table

_FILE_S = 10.0
"""The recording goes on in a next file so often; a file is compared and deleted while it does."""
_SAMPLE_S = 1.0
_CPU_LIMIT_PERCENT = 40.0
_OF_A_CORE = "% of a core"
_GROWTH_LIMIT_MB = 8.0
"""Events and the index of chunks grow with the recording: 200 bytes a frame."""
_PATIENCE_S = 60.0


def bench_rate(
    progress: Progress,
    folder: Path,
    *,
    seconds: float,
    cameras: int = 1,
    sends: Format | None = None,
) -> Table:
    """Record cameras side by side for so long, and compare every pixel with what was served."""
    sends = sends or Format()
    count = round(seconds * sends.rate_hz)
    with ExitStack() as running:
        rigs = [
            running.enter_context(Rig(folder, number=place + 1, sends=sends))
            for place in range(cameras)
        ]
        checkers = [running.enter_context(_Checker(rig)) for rig in rigs]
        for rig in rigs:
            rig.arm(frames=count, rotation=Rotation(seconds=_FILE_S))
        samples = _watch(rigs, count, seconds, progress)
        reports = [rig.client.finish(expected_frames=count) for rig in rigs]
        for checker, report in zip(checkers, reports, strict=True):
            checker.finish(report)
    rows = _rows(cameras * count, reports, checkers, samples)
    note = (
        f"{cameras} camera(s), {sends}, {sends.bytes_per_s * cameras / 1e6:.0f} MB/s for "
        f"{seconds:g} s into {folder}, in files of {_FILE_S:g} s; cameras and comparison on this "
        "host too."
    )
    return Table(f"Full rate, {cameras} camera(s)", rows, (note,))


class _Checker(threading.Thread):
    """Compares each file of a recording once it is whole, and deletes it: ten minutes are 72 GB."""

    def __init__(self, rig: Rig) -> None:
        super().__init__(name=f"check {rig.address}", daemon=True)
        self.differing = 0
        self.files = 0
        self.error: Exception | None = None
        self._rig = rig
        self._files_in_all: int | None = None
        self._abandoned = False

    def __enter__(self) -> "_Checker":
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._abandoned = True
        self.join()

    def finish(self, report: CaptureReport) -> None:
        """Compare what is left; raises what went wrong."""
        self._files_in_all = len(report.paths)
        self.join(_PATIENCE_S)
        if self.error is not None:
            raise self.error

    def run(self) -> None:
        try:
            while not self._abandoned and self.files != self._files_in_all:
                self._look()
        except Exception as error:  # noqa: BLE001  handed to the thread that asks for the result
            self.error = error

    def _look(self) -> None:
        path = part_path(self._rig.path, self.files + 1)
        if not path.exists():
            time.sleep(_SAMPLE_S / 4)
            return
        self.differing += differing([path], self._rig.served)
        path.unlink()
        self.files += 1


class _Sample:
    """Receivers and recorders together, at one moment."""

    def __init__(self, rigs: Sequence[Rig]) -> None:
        receivers = [usage_of(rig.capture_pid) for rig in rigs]
        recorders = [usage_of(rig.recorder_pid) for rig in rigs]
        self.at_s = time.monotonic()
        self.receiver_s = sum(usage.cpu_s for usage in receivers)
        self.recorder_s = sum(usage.cpu_s for usage in recorders)
        self.own_mb = sum(usage.own_bytes for usage in receivers + recorders) / 1e6

    @property
    def both_s(self) -> float:
        """Processor seconds of all."""
        return self.receiver_s + self.recorder_s


def _watch(rigs: Sequence[Rig], count: int, seconds: float, progress: Progress) -> list[_Sample]:
    samples = [_Sample(rigs)]
    until_s = samples[0].at_s + 2.0 * seconds + _PATIENCE_S
    while any(rig.client.status().state is not CaptureState.RECORDED for rig in rigs):
        time.sleep(_SAMPLE_S)
        samples.append(_Sample(rigs))
        status = rigs[0].client.status()
        progress(min(1.0, status.recorded / count), f"{status.recorded} of {count} frames")
        if samples[-1].at_s > until_s:
            raise TimeoutError(f"{count} frames did not come in twice their time: {status}")
    return samples


def _rows(
    count: int,
    reports: Sequence[CaptureReport],
    checkers: Sequence[_Checker],
    samples: Sequence[_Sample],
) -> list[Row]:
    # The first seconds fill caches and allocate; steady is what is asked.
    settled = samples[min(len(samples) - 1, max(1, len(samples) // 10))]
    grown_mb = samples[-1].own_mb - settled.own_mb
    recorded = sum(report.recorded for report in reports)
    return [
        figure(f"frames recorded of {count}", recorded, str(count), holds=recorded == count),
        none_of("frames lost", sum(report.lost + report.refused for report in reports)),
        none_of("frames that differ", sum(checker.differing for checker in checkers)),
        *_cpu_rows(samples, len(reports)),
        figure(
            "memory of their own after a tenth and at the end, MB",
            samples[-1].own_mb,
            f"growth <= {_GROWTH_LIMIT_MB:g}",
            holds=grown_mb <= _GROWTH_LIMIT_MB,
            spread=f"from {settled.own_mb:.1f}",
        ),
        figure(
            "packets sent again",
            sum(report.resent_packets for report in reports),
            "",
            holds=True,
        ),
    ]


def _cpu_rows(samples: Sequence[_Sample], cameras: int) -> list[Row]:
    """Return the cost of a camera; the limit is for the mean, single seconds may be above."""
    first, last = samples[0], samples[-1]
    pairs = list(zip(samples, samples[1:-1], strict=False)) or [(first, last)]

    def percent(spent_s: float, before: _Sample, after: _Sample) -> float:
        return 100.0 * spent_s / (after.at_s - before.at_s) / cameras

    seconds = [percent(b.both_s - a.both_s, a, b) for a, b in pairs]
    both = below("receiver and recorder of a camera", seconds, _CPU_LIMIT_PERCENT, _OF_A_CORE)
    mean = sum(seconds) / len(seconds)
    receiver = percent(last.receiver_s - first.receiver_s, first, last)
    return [
        {**both, "holds": mean <= _CPU_LIMIT_PERCENT},
        figure(f"of that the receiver, {_OF_A_CORE}", receiver, "", holds=True),
    ]
