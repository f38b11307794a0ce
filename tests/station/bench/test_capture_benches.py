"""Do the benches of capture find what they look for?  Small pictures and short runs, whose figures
are no claims; that a fault is seen at all is shown by planting it."""

import gc
import os
import subprocess
import time

import numpy as np
import pytest

from station.bench import BENCHES, CAPTURE_PARTS, capture_benches, capture_kills, capture_returns
from station.bench import capture_bad_files as bad_files
from station.bench.capture_bad_files import bench_bad_files
from station.bench.capture_disk import bench_full_disk
from station.bench.capture_kills import _VICTIMS, bench_kills
from station.bench.capture_packets import FAULTS, bench_packets
from station.bench.capture_rate import bench_rate
from station.bench.capture_returns import bench_returns
from station.bench.capture_rig import Format, Rig, differing
from station.bench.figures import below, none_of
from station.bench.processes import children_of, has_ended, usage_of
from station.cli.main import build_app, run
from station.errors import InputUnusable, RecordingUnreadable
from station.progress import silent

SMALL = Format(width_px=320, height_px=240, rate_hz=40.0)
RUNS_ANYWHERE = (
    "receiver and recorder of a camera, % of a core",
    "memory of their own",
    "noticed after",
    "going on after its return",
    *(f"{n} kills of {victim}: lost" for n in (1, 3) for victim in _VICTIMS.values()),
)
"""Costs and times on a busy host say nothing of the chain's correctness."""


def rows_of(table):
    return {row["what"]: row for row in table.rows}


def assert_holds(table):
    wrong = [row for row in table.rows if not row["holds"]]
    wrong = [
        row for row in wrong if not any(row["what"].startswith(what) for what in RUNS_ANYWHERE)
    ]
    assert wrong == []


def test_two_cameras_are_recorded_and_compared_file_by_file(tmp_path):
    table = bench_rate(silent, tmp_path, seconds=1.0, cameras=2, sends=SMALL)
    assert_holds(table)
    assert rows_of(table)["frames recorded of 80"]["figure"] == 80
    assert list(tmp_path.glob("*.mcap")) == []


def test_a_frame_that_differs_is_counted(tmp_path):
    with Rig(tmp_path, sends=SMALL) as rig:
        rig.record(5)
        assert differing([rig.path], rig.served) == 0
        rig.served._frames[2].setflags(write=True)
        rig.served._frames[2][7, 7] ^= 1
        assert differing([rig.path], rig.served) == 1


def test_every_fault_of_the_link_is_overcome_or_reported(tmp_path):
    all_at_once = {"1 % each": FAULTS["1 % each"]}
    table = bench_packets(silent, tmp_path, count=20, sends=SMALL, faults=all_at_once)
    assert_holds(table)
    assert len(table.rows) == 1 + 4


@pytest.mark.parametrize("kills", [1, pytest.param(3, marks=pytest.mark.slow)])
def test_kills_leave_readable_files(tmp_path, kills):
    table = bench_kills(silent, tmp_path, kills=kills, sends=SMALL)
    assert_holds(table)
    assert len(table.rows) == kills * 5


def test_what_a_kill_costs_is_counted():
    sound = capture_kills._Death("both", True, 0, 0, 0.02, silent=False)
    spoilt = capture_kills._Death("both", False, 1, 7, 1.5, silent=True)
    rows = capture_kills._rows("both", [sound, spoilt])
    assert [row["figure"] for row in rows] == [1, 1, 7, 1, 0.76]
    assert not any(row["holds"] for row in rows)
    assert capture_kills._rows("recorder", [sound]) == []


def test_a_file_that_cannot_be_made_whole_is_not_readable(tmp_path):
    path = tmp_path / "1.mcap"
    path.with_name("1.mcap.active").write_bytes(b"no recording")
    death = capture_kills._looked_at("both", path, 7, 9, None, 10.0)
    assert not death.readable
    assert (death.confirmed_lost, death.lost_s, death.silent) == (7, 0.9, True)


@pytest.mark.parametrize("returns", [1, pytest.param(3, marks=pytest.mark.slow)])
def test_a_camera_that_returns_is_recorded_again(tmp_path, returns, monkeypatch):
    if returns == 1:  # what is held after the first return is compared with itself
        monkeypatch.setattr(capture_returns, "_SETTLE_S", 0.0)
    table = bench_returns(silent, tmp_path, returns=returns, sends=SMALL)
    assert_holds(table)
    assert rows_of(table)["gaps in the file's events"]["figure"] == returns


@pytest.mark.slow
def test_a_full_disk_ends_the_recording_whole(tmp_path):
    assert_holds(bench_full_disk(silent, tmp_path))


def test_bad_files_are_all_named(tmp_path):
    table = bench_bad_files(silent, tmp_path)
    assert_holds(table)
    assert len(table.rows) == 2 * 5 + 1


def test_a_reader_that_believes_or_crashes_is_counted(tmp_path, monkeypatch):
    def crash(_path):
        raise IndexError

    sound = bad_files._sound_recording(tmp_path / "sound.mcap")
    assert bad_files._named(sound) is False
    monkeypatch.setattr(bad_files, "verify", crash)
    assert bad_files._named(sound) is None


def test_a_file_that_one_reader_names_is_named(tmp_path, monkeypatch):
    def refuse(_path):
        raise RecordingUnreadable("planted")

    sound = bad_files._sound_recording(tmp_path / "sound.mcap")
    monkeypatch.setattr(bad_files, "info", refuse)
    assert bad_files._named(sound) is True


def test_usage_is_that_of_the_process():
    gc.collect()  # so that nothing that others left is closed meanwhile
    before, began_s = usage_of(os.getpid()), time.process_time()
    ballast = np.ones(8_000_000)  # more than a process keeps of what it freed before
    while time.process_time() < began_s + 0.3:
        pass
    with open(os.devnull):
        after, used_s = usage_of(os.getpid()), time.process_time() - began_s
    # Ticks of 10 ms of two kinds at both ends, and what threads of others did between two looks.
    assert after.cpu_s - before.cpu_s == pytest.approx(used_s, abs=0.1)
    assert after.descriptors == before.descriptors + 1
    assert after.own_bytes - before.own_bytes > 0.9 * ballast.nbytes


def test_children_and_their_end_are_seen():
    child = subprocess.Popen(["sleep", "60"])
    assert child.pid in children_of(os.getpid())
    assert not has_ended(child.pid)
    child.kill()
    child.wait()
    assert has_ended(child.pid)


def test_rows_say_whether_what_is_asked_holds():
    assert none_of("lost", 0)["holds"]
    assert not none_of("lost", 1)["holds"]
    row = below("back", [1.0, 2.0, 8.0], 7.0, "s")
    assert (row["figure"], row["spread"], row["holds"]) == (2.0, "1 to 8", False)


def test_every_part_is_among_the_benches():
    assert len(BENCHES["capture"]) == len(CAPTURE_PARTS) == len(capture_benches(full=True))


def test_unknown_part_and_folder_are_refused(tmp_path):
    with pytest.raises(InputUnusable, match="allowed: rate"):
        capture_benches(["speed"])
    with pytest.raises(InputUnusable, match="make it first"):
        capture_benches(folder=tmp_path / "none")


def test_options_of_capture_are_refused_for_other_benches(capsys):
    assert run(build_app("bench"), ["bench", "stripe", "--full"]) == 2
    assert "station bench capture" in capsys.readouterr().err


def test_a_part_alone_is_measured_by_the_command(tmp_path, capsys):
    arguments = ["bench", "capture", "--part", "bad-files", "--folder", str(tmp_path), "--json"]
    assert run(build_app("bench"), arguments) == 0
    assert '"title": "Bad files"' in capsys.readouterr().out
    assert list(tmp_path.iterdir()) == []
