"""The processes of a pool end with the one that they calculate for, even if it is killed."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

from station.processes.pool import pool_of_processes
from station.processes.stop_signal import STOP_SIGNALS

PATIENCE_S = 30.0
CALCULATES = """
import os, time
from station.processes.pool import pool_of_processes

if __name__ == "__main__":
    with pool_of_processes(2) as pool:
        print(*{pool.submit(os.getpid).result() for _ in range(20)}, flush=True)
        time.sleep(600.0)
"""


def runs(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):
        return False


def test_processes_of_a_killed_one_do_not_wait_for_work_for_ever(tmp_path):
    program = tmp_path / "calculates.py"
    program.write_text(CALCULATES)
    with subprocess.Popen([sys.executable, program], stdout=subprocess.PIPE, text=True) as process:
        pids = [int(word) for word in process.stdout.readline().split()]
        assert pids
        assert all(runs(pid) for pid in pids)
        process.kill()
    deadline = time.monotonic() + PATIENCE_S
    try:
        while any(runs(pid) for pid in pids):
            assert time.monotonic() < deadline, "they outlived who they calculate for"
            time.sleep(0.05)
    finally:
        for pid in filter(runs, pids):
            os.kill(pid, signal.SIGKILL)


def test_a_stop_signal_to_all_processes_does_not_cut_off_the_work_of_a_pool():
    with pool_of_processes(1) as pool:
        (pid,) = {pool.submit(os.getpid).result()}
        for number in STOP_SIGNALS:
            os.kill(pid, number)
        # Asked after the signals, which a process meets before it takes up anything else.
        assert pool.submit(os.getpid).result() == pid
