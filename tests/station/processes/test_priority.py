"""Shows who goes behind whom; that the kernel keeps to it is its own affair."""

import os
import subprocess
import sys

import pytest

from station.processes.pool import pool_of_processes
from station.processes.priority import yields

WORKER = """
import os
from station.processes.pool import pool_of_processes
from station.processes.priority import yield_to_others

if __name__ == "__main__":
    yield_to_others()
    with pool_of_processes(1) as pool:
        print(os.nice(0), pool.submit(os.nice, 0).result())
"""
PROMPT = """
import gc, sys
from station.processes.priority import answer_promptly

answer_promptly()
print(sys.getswitchinterval() < 0.001, gc.get_freeze_count() > 0)
"""


def output_of(folder, code):
    program = folder / "program.py"
    program.write_text(code)
    return subprocess.check_output([sys.executable, program], text=True, timeout=60.0).split()


def test_what_a_worker_has_calculated_goes_behind_the_worker_and_both_behind_the_rest(tmp_path):
    worker, pool = output_of(tmp_path, WORKER)
    assert os.nice(0) < int(worker) < int(pool)


@pytest.mark.skipif(yields(), reason="the tests themselves were told to go behind others")
def test_what_a_person_waits_for_goes_behind_nobody():
    with pool_of_processes(1) as pool:
        assert pool.submit(os.nice, 0).result(60.0) == os.nice(0)


def test_threads_that_answer_take_turns_quickly_and_old_objects_are_not_collected_again(tmp_path):
    assert output_of(tmp_path, PROMPT) == ["True", "True"]
