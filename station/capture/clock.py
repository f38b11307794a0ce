"""The camera's clock and UTC: offset and drift, measured while recording.

The camera is asked for its time once a second.  What lies between question and answer bounds how
far the two clocks can be apart from what was seen, so the quickest answers count; a line through
them gives the drift.  A camera that cannot be asked is judged by its frames, the quickest of each
second: a frame leaves when its exposure ends, and never before.
"""

import itertools
import statistics
from dataclasses import dataclass
from enum import StrEnum

_MOST_SAMPLES = 48
_AGREES_NS = 500_000
"""A camera that keeps UTC as closely is believed as it is."""
_JUMP_NS = 20_000_000
"""A clock so far from its line was set anew."""
_SHORTEST_NS = 5_000_000_000
"""Over less time no drift can be told: a sample's 0.2 ms would be 40 ppm."""
_QUICK_NS = 300_000
_FRAME_DELAY_NS = 1_000_000
"""What a frame's first packet may take at least, beyond the exposure."""
_FRAME_WINDOW_NS = 1_000_000_000


class ClockSource(StrEnum):
    """Where a frame's time comes from; it stands in the recording."""

    CAMERA_UTC = "camera"
    """The camera keeps UTC (PTP)."""
    CAMERA_MAPPED = "camera, mapped to this host's UTC"
    """The camera keeps a time of its own; offset and drift are measured."""
    HOST = "host"
    """The camera has no clock: times are those of reception."""


@dataclass(frozen=True, slots=True)
class ClockSample:
    """What two clocks showed at the same moment."""

    camera_ns: int
    host_ns: int
    """UTC."""
    within_ns: int
    """How far from the same moment it can have been, either way."""

    @property
    def offset_ns(self) -> int:
        """What is added to the camera's time."""
        return self.host_ns - self.camera_ns


@dataclass(frozen=True, slots=True)
class ClockSummary:
    """How a camera's clock goes beside UTC."""

    source: ClockSource
    offset_ns: int = 0
    """What is added to the camera's time to have UTC, at the last sample."""
    drift_ppm: float | None = None
    """By how much the camera's clock runs fast; None where it was watched too briefly."""
    residual_us: float = 0.0
    """Median distance of the samples from the line."""
    samples: int = 0

    def to_text(self) -> dict[str, str]:
        """Return it as names and values for a recording."""
        drift = "" if self.drift_ppm is None else f"{self.drift_ppm:.3f}"
        return {
            "clock_source": str(self.source),
            "clock_offset_ns": str(self.offset_ns),
            "clock_drift_ppm": drift,
            "clock_residual_us": f"{self.residual_us:.1f}",
            "clock_samples": str(self.samples),
        }


class CameraClock:
    """Maps a camera's timestamps to UTC, ns.

    Parameters
    ----------
    tick_frequency_hz
        Of the camera's clock; 0 is a camera without one.
    exposure_ns
        Time from a frame's timestamp to its first packet at least.
    """

    def __init__(self, tick_frequency_hz: int, exposure_ns: int = 0) -> None:
        # Without a tick frequency Aravis silently puts the host's time in its place.
        self._has_clock = tick_frequency_hz > 0
        self._exposure_ns = exposure_ns
        self._asked = False
        self._samples: list[ClockSample] = []
        self._window: ClockSample | None = None
        self._line = _Line(0, 0, None)
        self.jumps = 0
        """How often the clock was found set anew."""

    @property
    def source(self) -> ClockSource:
        """Where times come from at present."""
        if not self._has_clock:
            return ClockSource.HOST
        if not self._samples:
            return ClockSource.CAMERA_UTC
        best_ns = min(sample.within_ns for sample in self._samples)
        offset_ns = self._line.offset_ns(self._samples[-1].camera_ns)
        agrees = abs(offset_ns) <= max(_AGREES_NS, best_ns)
        return ClockSource.CAMERA_UTC if agrees else ClockSource.CAMERA_MAPPED

    def learn(self, sample: ClockSample) -> None:
        """Take what the camera answered when it was asked for its time."""
        if not self._asked:
            self._asked, self._window = True, None
            self._samples.clear()
        self._add(sample)

    def utc_ns(self, camera_ns: int, received_ns: int) -> int:
        """Return the UTC time of a frame stamped `camera_ns` and received at `received_ns`."""
        if not self._has_clock:
            return received_ns
        if not self._asked:
            self._learn_from_frame(camera_ns, received_ns)
        if self.source is ClockSource.CAMERA_UTC:
            return camera_ns
        return camera_ns + self._line.offset_ns(camera_ns)

    def summary(self) -> ClockSummary:
        """Return how the clock has gone so far."""
        if not self._samples:
            return ClockSummary(self.source)
        last, line = self._samples[-1], self._line
        distances = [abs(s.offset_ns - line.offset_ns(s.camera_ns)) for s in self._samples]
        return ClockSummary(
            source=self.source,
            offset_ns=line.offset_ns(last.camera_ns),
            drift_ppm=None if line.slope is None else -1e6 * line.slope,
            residual_us=statistics.median(distances) * 1e-3,
            samples=len(self._samples),
        )

    def _learn_from_frame(self, camera_ns: int, received_ns: int) -> None:
        """Keep the quickest frame of each second."""
        left_ns = received_ns - self._exposure_ns
        sample = ClockSample(camera_ns, left_ns, _FRAME_DELAY_NS)
        if not self._samples:
            self._add(sample)
        window = self._window
        if window is None or sample.offset_ns < window.offset_ns:
            self._window = sample
        if window is not None and camera_ns - window.camera_ns > _FRAME_WINDOW_NS:
            self._add(window)
            self._window = sample

    def _add(self, sample: ClockSample) -> None:
        if self._samples:
            expected_ns = self._line.offset_ns(sample.camera_ns)
            if abs(sample.offset_ns - expected_ns) > _JUMP_NS + 2 * sample.within_ns:
                self.jumps += 1
                self._samples.clear()
        self._samples.append(sample)
        if len(self._samples) > _MOST_SAMPLES:
            self._samples = _quicker_of_pairs(self._samples)
        self._line = self._fitted()

    def _fitted(self) -> "_Line":
        """Return the line through the quick samples: the median of slopes, then of offsets.

        Theil's line: a third of the samples may be anywhere.
        """
        quickest_ns = min(sample.within_ns for sample in self._samples)
        limit_ns = max(3 * quickest_ns, _QUICK_NS)
        quick = [sample for sample in self._samples if sample.within_ns <= limit_ns]
        last, span_ns = quick[-1], quick[-1].camera_ns - quick[0].camera_ns
        if span_ns < _SHORTEST_NS:
            return _Line(last.camera_ns, last.offset_ns, None)
        slope = statistics.median(
            (b.offset_ns - a.offset_ns) / (b.camera_ns - a.camera_ns)
            for a, b in itertools.combinations(quick, 2)
            if b.camera_ns - a.camera_ns >= span_ns // 3
        )
        offsets = [s.offset_ns - slope * (s.camera_ns - last.camera_ns) for s in quick]
        return _Line(last.camera_ns, round(statistics.median(offsets)), slope)


@dataclass(frozen=True, slots=True)
class _Line:
    """What is added to the camera's time; without a slope, drift is not yet known."""

    at_ns: int
    value_ns: int
    slope: float | None

    def offset_ns(self, camera_ns: int) -> int:
        return self.value_ns + round((self.slope or 0.0) * (camera_ns - self.at_ns))


def _quicker_of_pairs(samples: list[ClockSample]) -> list[ClockSample]:
    """Halve the samples: of two neighbours the quicker stays; the newest stay as they are."""
    older, newer = samples[: len(samples) // 2 * 2 - 8], samples[len(samples) // 2 * 2 - 8 :]
    pairs = zip(older[::2], older[1::2], strict=True)
    return [min(pair, key=lambda s: (s.within_ns, s.offset_ns)) for pair in pairs] + newer
