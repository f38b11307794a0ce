"""kill -9 at random moments: what is readable afterwards, and what is lost against the camera."""

import os
import signal
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from station.bench.capture_rig import Format, Rig, differing, wait_for_end
from station.bench.figures import Row, below, none_of
from station.errors import StationError
from station.progress import Progress
from station.recording import LOSSES, EventKind, active_path, events, recover, verify
from station.simulated import ArraySource
from station.tables import Table

_VICTIMS = {"both": "both", "capture": "the receiver", "recorder": "the recorder"}
_EARLIEST_S, _LATEST_S = 0.2, 2.5
_AFTERWARDS_S = 0.5
_LOST_LIMIT_S = 1.0


@dataclass(frozen=True, slots=True)
class _Death:
    """What one kill left."""

    victim: str
    readable: bool
    """The file is whole after recovery, and passes its verification."""
    different: int
    confirmed_lost: int
    """Frames that had been said to be recorded and are not in the file."""
    lost_s: float
    """How much of what the camera had exposed by then is not in the file."""
    silent: bool
    """Nothing in the file says that it was interrupted."""


def bench_kills(
    progress: Progress, folder: Path, *, kills: int, seed: int = 0, sends: Format | None = None
) -> Table:
    """Kill the receiver, the recorder or both, at random moments of a recording at full rate."""
    rng = np.random.default_rng(seed)
    deaths = []
    for place in range(kills):
        victim = list(_VICTIMS)[place % len(_VICTIMS)]
        after_s = rng.uniform(_EARLIEST_S, _LATEST_S)
        progress(place / kills, f"kill {place + 1} of {kills}: {victim}")
        with tempfile.TemporaryDirectory(dir=folder) as own:
            deaths.append(_kill(Path(own), victim, after_s, sends or Format()))
    rows = [row for victim in _VICTIMS for row in _rows(victim, deaths)]
    when = f"{_EARLIEST_S:g} to {_LATEST_S:g} s after arming"
    note = f"{kills} kills in turn, {when}, {sends or Format()}."
    return Table("kill -9 while recording", rows, (note,))


def _kill(folder: Path, victim: str, after_s: float, sends: Format) -> _Death:
    with Rig(folder, sends=sends) as rig:
        path = rig.arm()
        time.sleep(after_s)
        confirmed = rig.client.status().recorded
        if victim == "recorder":
            os.kill(rig.recorder_pid, signal.SIGKILL)
            time.sleep(_AFTERWARDS_S)
            report = rig.client.finish()
            exposed = report.recorded + report.lost + report.refused
        else:
            exposed = _kill_capture(rig, with_recorder=victim == "both")
    return _looked_at(victim, path, confirmed, exposed, rig.served, sends.rate_hz)


def _looked_at(
    victim: str, path: Path, confirmed: int, exposed: int, served: ArraySource, rate_hz: float
) -> _Death:
    """Recover what was left, where it needs that, and look at it."""
    try:
        if active_path(path).exists():
            recover(active_path(path))
        kinds = {event.kind for event in events(path)}
        proved = verify(path)
        different = differing([path], served)
    except StationError:
        return _Death(victim, False, 0, confirmed, exposed / rate_hz, silent=True)
    return _Death(
        victim=victim,
        readable=proved.ok,
        different=different,
        confirmed_lost=max(0, confirmed - proved.frames),
        lost_s=max(0, exposed - proved.frames) / rate_hz,
        silent=kinds.isdisjoint(LOSSES | {EventKind.RECORDER_RESTARTED}),
    )


def _kill_capture(rig: Rig, *, with_recorder: bool) -> int:
    """Kill the receiver; return how many frames the camera had exposed by then."""
    if with_recorder:
        # Held first, so that it cannot finish what the other leaves.
        os.kill(rig.recorder_pid, signal.SIGSTOP)
    rig.process.kill()
    exposed = rig.camera.statistics().exposed
    if with_recorder:
        os.kill(rig.recorder_pid, signal.SIGKILL)
    rig.process.join()
    wait_for_end(rig.recorder_pid)
    return exposed


def _rows(victim: str, deaths: Sequence[_Death]) -> list[Row]:
    ours = [death for death in deaths if death.victim == victim]
    if not ours:
        return []
    name = f"{len(ours)} kills of {_VICTIMS[victim]}"
    return [
        none_of(f"{name}: files not readable", sum(not death.readable for death in ours)),
        none_of(f"{name}: frames that differ", sum(death.different for death in ours)),
        none_of(f"{name}: confirmed frames lost", sum(death.confirmed_lost for death in ours)),
        none_of(f"{name}: files that do not say so", sum(death.silent for death in ours)),
        below(f"{name}: lost", [death.lost_s for death in ours], _LOST_LIMIT_S, "s"),
    ]
