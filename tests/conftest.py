from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

# The same examples on every machine and every day: a red run is a change, not a draw.
settings.register_profile("fixed", derandomize=True)
settings.load_profile("fixed")


@pytest.fixture
def rng():
    return np.random.default_rng(20240501)


# Cameras, stations and databases of the tests have fixed addresses on loopback, and frames to keep
# up with: where several processes run the tests, one of them has all of these, from the beginning.
ONE_MACHINE = ("station", "system", "deploy")


def pytest_collection_modifyitems(items):
    here = Path(__file__).parent
    places = [
        item.path.relative_to(here).parts if item.path.is_relative_to(here) else ("",)
        for item in items
    ]
    alone = [place[0] in ONE_MACHINE for place in places]
    for item, is_alone in zip(items, alone, strict=True):
        if is_alone:
            item.add_marker(pytest.mark.xdist_group("one machine"))
    order = sorted(range(len(items)), key=lambda at: not alone[at])
    items[:] = [items[at] for at in order]


# The doctest collector would import every conftest under the one name, and refuse the second.
collect_ignore_glob = ["*conftest.py"]
