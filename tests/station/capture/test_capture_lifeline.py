"""The capture process ends with the process that started it, however early that one dies."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

ADDRESS = "127.40.1.1"
PATIENCE_S = 20.0
DIES_AT_ONCE = """
import os, signal, sys
from pathlib import Path
from station.capture import start_capture
from station.settings import SensorSettings
settings = SensorSettings(id="left", address=sys.argv[1])
print(start_capture(settings, Path(sys.argv[2])).pid, flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""


def runs(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def test_starter_that_is_killed_before_the_capture_process_has_begun_leaves_none(tmp_path):
    with subprocess.Popen(
        [sys.executable, "-c", DIES_AT_ONCE, ADDRESS, tmp_path / "s.sock"],
        stdout=subprocess.PIPE,
        text=True,
    ) as starter:
        pid = int(starter.stdout.readline())
        starter.wait(PATIENCE_S)
    deadline = time.monotonic() + PATIENCE_S
    try:
        while runs(pid):
            assert time.monotonic() < deadline, "it outlived who started it"
            time.sleep(0.05)
    finally:
        if runs(pid):
            os.kill(pid, signal.SIGKILL)
