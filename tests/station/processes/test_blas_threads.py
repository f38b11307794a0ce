"""In how many threads processes that calculate solve; how much that saves is for a bench."""

import os
import subprocess
import sys

import pytest

_BLAS_OF_A_PROCESS = """
import numpy
from station.processes.one_core import use_one_core

def threads():
    import scipy.linalg
    from threadpoolctl import threadpool_info
    return sorted({pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"})
"""
_ITSELF = """
use_one_core()
print(*threads())
"""
_ITS_POOL = """
from station.processes.pool import pool_of_processes
if __name__ == "__main__":
    with pool_of_processes(1) as pool:
        print(*pool.submit(threads).result())
"""


def threads_of(tmp_path, program, **environment):
    path = tmp_path / "calculates.py"
    path.write_text(_BLAS_OF_A_PROCESS + program)
    inherited = {name: value for name, value in os.environ.items() if "NUM_THREADS" not in name}
    done = subprocess.run(
        [sys.executable, path],
        env=inherited | environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.split()


@pytest.mark.parametrize("program", [_ITSELF, _ITS_POOL], ids=["itself", "its pool"])
def test_a_process_that_calculates_solves_with_one_thread(tmp_path, program):
    assert threads_of(tmp_path, program) == ["1"]


@pytest.mark.parametrize("program", [_ITSELF, _ITS_POOL], ids=["itself", "its pool"])
def test_the_users_own_number_of_threads_counts(tmp_path, program):
    asked = str(min(2, len(os.sched_getaffinity(0))))
    assert threads_of(tmp_path, program, OPENBLAS_NUM_THREADS=asked) == [asked]
