import numpy as np
import pytest


@pytest.fixture
def rng():
    return np.random.default_rng(20240501)


# The doctest collector would import every conftest under the one name, and refuse the second.
collect_ignore_glob = ["*conftest.py"]
