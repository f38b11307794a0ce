import subprocess
import sys

_PAGES_ASKED_FOR = """
import resource, sys
import numpy as np
if sys.argv[1] == "kept":
    from station.processes.one_core import use_one_core
    use_one_core()
def faults():
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt
pictures = [np.ones(2_000_000, np.uint8) for _ in range(3)]
before = faults()
for _ in range(20):
    pictures = [np.ones(2_000_000, np.uint8) for _ in range(3)]
    del pictures
print(faults() - before)
"""


def pages_asked_for(how: str) -> int:
    done = subprocess.run(
        [sys.executable, "-c", _PAGES_ASKED_FOR, how], capture_output=True, text=True, check=True
    )
    return int(done.stdout)


def test_a_process_of_one_core_keeps_the_memory_of_pictures_it_frees():
    # Three pictures are 1465 pages; kept, they are asked for once, given back, each time.
    assert pages_asked_for("kept") < 5_000
    assert pages_asked_for("given back") > 10_000
