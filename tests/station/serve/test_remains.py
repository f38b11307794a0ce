"""Shows what a start finds of a station that was killed: its processes are waited for, the folder
of its sockets goes, and nobody else's does."""

import subprocess
import sys

import pytest

from station.errors import StateConflict
from station.operations import DataLayout
from station.serve import remains
from station.serve.remains import await_end_of_killed, folder_of_sockets

SHARES = """
import sys, time
from pathlib import Path
from station.processes.lock import share
share(Path(sys.argv[1]))
print("shares", flush=True)
sys.stdin.readline()
"""


@pytest.fixture
def layout(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    layout = DataLayout(tmp_path / "data")
    layout.ensure()
    return layout


@pytest.fixture
def remaining(layout):
    """A process of a station that was killed, as it ends in order."""
    command = [sys.executable, "-c", SHARES, layout.processes_lock]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) as process:
        assert process.stdout.readline() == "shares\n"
        yield process
        process.kill()


def test_a_process_that_still_ends_is_waited_for(layout, remaining):
    naps = []

    def end_after_two(seconds):
        naps.append(seconds)
        if len(naps) == 2:
            remaining.stdin.write("\n")
            remaining.stdin.flush()
            remaining.wait()

    await_end_of_killed(layout, end_after_two)
    assert remaining.returncode == 0
    await_end_of_killed(layout, end_after_two)
    assert len(naps) == 2


def test_a_process_that_never_ends_is_told_of(layout, remaining, monkeypatch):
    monkeypatch.setattr(remains, "_PATIENCE_S", 0.2)
    with pytest.raises(StateConflict, match="a process of a killed station runs already"):
        await_end_of_killed(layout)


def test_shares_do_not_keep_each_other_waiting(layout, remaining):
    command = [sys.executable, "-c", SHARES, layout.processes_lock]
    done = subprocess.run(
        command, input="\n", capture_output=True, text=True, check=True, timeout=30
    )
    assert done.stdout == "shares\n"


def test_the_folder_of_a_killed_station_is_removed_and_that_of_an_ended_one_is_gone(layout):
    killed = folder_of_sockets(layout)
    left = killed.__enter__()
    (left / "left.sock").touch()
    assert left.stat().st_mode & 0o777 == 0o700
    with folder_of_sockets(layout) as present:
        assert not left.exists()
        assert present.is_dir()
    assert not present.exists()
    assert not layout.sockets_note.exists()


@pytest.mark.parametrize("name", ["precious", "treadline-file", "treadline-link"])
def test_what_is_no_folder_of_sockets_is_left_alone(layout, tmp_path, name):
    precious = tmp_path / "precious"
    precious.mkdir()
    (precious / "paper").touch()
    noted = tmp_path / name
    if name.endswith("file"):
        noted.touch()
    elif name.endswith("link"):
        noted.symlink_to(precious)
    layout.sockets_note.write_text(str(noted))
    with folder_of_sockets(layout):
        pass
    assert noted.exists()
    assert (precious / "paper").exists()
