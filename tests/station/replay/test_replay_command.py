"""The command itself, interrupted and killed: no process is left, and the next one goes on."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from wheel_recordings import record, true_calibration, views_of

from station.scenes import WheelTruth

pytestmark = pytest.mark.slow
STATION = [sys.executable, "-m", "station"]


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    """Return a folder with 30 recordings and a calibration."""
    folder = tmp_path_factory.mktemp("archive")
    views = views_of(WheelTruth(), (-20.0, 0.0), np.random.default_rng(5), seed=1)
    (first,) = record(folder / "train00.mcap", [views] * 3)
    for number in range(1, 30):
        (folder / f"train{number:02}.mcap").hardlink_to(first)
    true_calibration().write(folder / "calibration.json")
    return folder


def command(archive, out):
    return [*STATION, "replay", archive, "--calibration", archive / "calibration.json"] + [
        *("--out", out, "--workers", "2", "--json")
    ]


def wait_until(holds, what):
    ends = time.monotonic() + 60.0
    while not holds():
        assert time.monotonic() < ends, what
        time.sleep(0.02)


def processes_of(group):
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _parent, its_group = stat.read_text().rpartition(")")[2].split()[:3]
        except OSError:
            continue
        if int(its_group) == group and state != "Z":
            found.append(stat)
    return found


@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, -15), (signal.SIGKILL, -9)]
)
def test_a_replay_that_is_stopped_leaves_no_process_and_the_next_goes_on(
    archive, tmp_path, number, code
):
    out = tmp_path / "results"
    replay = subprocess.Popen(
        list(map(str, command(archive, out))), start_new_session=True, stdout=subprocess.DEVNULL
    )
    wait_until(lambda: len(list(out.glob("*.parquet"))) >= 3, "no part was written")
    replay.send_signal(number)
    assert replay.wait(timeout=60.0) == code
    wait_until(lambda: not processes_of(replay.pid), "a worker outlived the replay")
    done = len(list(out.glob("*.parquet")))
    assert 3 <= done < 30
    said = subprocess.run(
        list(map(str, command(archive, out))), capture_output=True, check=True, timeout=120.0
    )
    report = json.loads(said.stdout)
    assert (report["recordings"], report["found_measured"]) == (30, done)
    assert report["wheels"] == 90
