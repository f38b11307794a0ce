"""Two workers for all tests of replaying: to start them takes seconds."""

import dask
import pytest

from station.replay import local_workers

TLS = "distributed.comm.tls"


@pytest.fixture(scope="session")
def workers():
    with local_workers(2) as crew:
        yield crew


@pytest.fixture
def cluster(workers, tmp_path):
    """The address of the workers' scheduler, and Dask configured as a site has it that runs one."""
    papers = workers._client.security
    given = {
        f"{TLS}.ca-file": papers.tls_ca_file,
        f"{TLS}.client.cert": papers.tls_client_cert,
        f"{TLS}.client.key": papers.tls_client_key,
    }
    for name, content in given.items():
        (tmp_path / name).write_text(content)
    with dask.config.set({name: str(tmp_path / name) for name in given}):
        yield workers._client.scheduler.address
