"""Two workers for all tests of replaying: to start them takes seconds."""

import pytest

from station.replay import local_workers


@pytest.fixture(scope="session")
def workers():
    with local_workers(2) as crew:
        yield crew
