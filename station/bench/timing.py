"""Seconds of one core that a piece of work takes."""

import time
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from station.processes.one_core import use_one_core


@dataclass(frozen=True, slots=True)
class CoreTime:
    """What one run took, s: the median of several, and how far half of them lie apart."""

    median_s: float
    spread_s: float

    @classmethod
    def of(cls, work: Callable[[], object], *, runs: int) -> "CoreTime":
        """Run `work` once for nothing, then `runs` times by the clock of the processor.

        That clock counts what all threads of this process use and not what others do meanwhile.
        """
        threads = cv2.getNumThreads()
        use_one_core()
        try:
            work()
            taken = [_core_seconds(work) for _ in range(runs)]
        finally:
            cv2.setNumThreads(threads)
        low, middle, high = np.percentile(taken, [25.0, 50.0, 75.0])
        return cls(float(middle), float(high - low))


def _core_seconds(work: Callable[[], object]) -> float:
    began = time.process_time()
    work()
    return time.process_time() - began
