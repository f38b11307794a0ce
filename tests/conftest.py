import os

# Two runs share the cores: threads of BLAS that wait for each other there turn seconds into many.
# It is read when numpy is first imported, here and in every process that a test starts.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

# The same examples on every machine and every day: a red run is a change, not a draw.
# Nor may it be a busy host: how long an example takes is asked by no test.
settings.register_profile(
    "fixed", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile("fixed")


@pytest.fixture
def rng():
    return np.random.default_rng(20240501)


# The doctest collector would import every conftest under the one name, and refuse the second.
collect_ignore_glob = ["*conftest.py"]
