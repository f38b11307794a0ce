"""A camera that loses its power and comes back, again and again."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from station.bench.capture_rig import Format, Rig, differing
from station.bench.figures import Row, below, figure, none_of
from station.bench.processes import Usage, usage_of
from station.capture import CaptureState
from station.progress import Progress
from station.recording import EventKind, events, verify
from station.tables import Table

_NOTICE_LIMIT_S = 6.0
_GO_ON_LIMIT_S = 7.0
_OFF_S = 0.5
_MEMORY_LIMIT_MB = 4.0
_SETTLE_S = 3.0
"""The remains of a lost camera are let go of in a thread of their own, 2.5 s at the most each."""


@dataclass(frozen=True, slots=True)
class _Return:
    """One death and return."""

    noticed_s: float
    """From the camera's end until the status says so."""
    back_s: float
    """From its first answer until the next frame was in the file."""


def bench_returns(
    progress: Progress, folder: Path, *, returns: int, sends: Format | None = None
) -> Table:
    """Kill the camera of a recording and start it again, so often."""
    with Rig(folder, sends=sends) as rig:
        rig.arm()
        rig.wait_until(lambda status: status.recorded > 0)
        found, usages = [], []
        for place in range(returns):
            progress(place / returns, f"return {place + 1} of {returns}")
            found.append(_return(rig))
            time.sleep(_SETTLE_S)
            usages.append((usage_of(rig.capture_pid), usage_of(rig.recorder_pid)))
        report = rig.client.finish()
    wrong = differing([rig.path], rig.served)
    gaps = sum(event.kind is EventKind.CAMERA_LOST for event in events(rig.path))
    rows = [
        below("noticed after", [one.noticed_s for one in found], _NOTICE_LIMIT_S, "s"),
        below("going on after its return", [one.back_s for one in found], _GO_ON_LIMIT_S, "s"),
        figure("gaps in the file's events", gaps, str(returns), holds=gaps == returns),
        figure("called complete", report.complete, "no", holds=not report.complete),
        none_of("frames that differ", wrong),
        none_of("problems that verify finds", len(verify(rig.path).problems)),
        *_usage_rows(usages),
    ]
    note = f"{returns} returns of a camera off for {_OFF_S:g} s and its start, {rig.sends}."
    return Table("Camera killed and back", rows, (note,))


def _return(rig: Rig) -> _Return:
    rig.power_off_camera()
    off_s = time.monotonic()
    rig.wait_until(lambda status: status.state is CaptureState.BLIND)
    noticed_s = time.monotonic() - off_s
    time.sleep(_OFF_S)
    rig.power_on_camera()
    on_s = time.monotonic()
    before = rig.client.status().recorded
    rig.wait_until(lambda status: status.recorded > before)
    return _Return(noticed_s, time.monotonic() - on_s)


def _usage_rows(usages: Sequence[tuple[Usage, Usage]]) -> list[Row]:
    """Compare what the processes hold after the first return and after the last."""
    (first, last) = usages[0], usages[-1]
    rows = []
    for name in ("threads", "descriptors"):
        before, after = (sum(getattr(usage, name) for usage in both) for both in (first, last))
        rows.append(
            figure(
                f"{name} after the last",
                after,
                f"{before}, as after the first",
                holds=after <= before,
            )
        )
    before_mb, after_mb = (sum(usage.own_bytes for usage in both) / 1e6 for both in (first, last))
    rows.append(
        figure(
            "memory of their own after the last, MB",
            after_mb,
            f"<= {before_mb:.1f} + {_MEMORY_LIMIT_MB:g}",
            holds=after_mb <= before_mb + _MEMORY_LIMIT_MB,
        )
    )
    return rows
