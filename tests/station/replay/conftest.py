"""Two workers for all tests of replaying: to start them takes seconds."""

import pytest
from dask_site import configured_for

from station.replay import local_workers


@pytest.fixture(scope="session")
def workers():
    with local_workers(2) as crew:
        yield crew


@pytest.fixture
def cluster(workers, tmp_path):
    """The address of the workers' scheduler, and Dask configured as a site has it that runs one."""
    with configured_for(workers, tmp_path) as address:
        yield address
