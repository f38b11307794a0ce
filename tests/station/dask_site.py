"""Dask's configuration as a site has it that runs the workers of a test."""

from contextlib import contextmanager

import dask

TLS = "distributed.comm.tls"


@contextmanager
def configured_for(crew, folder):
    """Have what speaks to a crew's scheduler show the crew's papers; yield its address."""
    papers = crew._client.security
    given = {
        f"{TLS}.ca-file": papers.tls_ca_file,
        f"{TLS}.client.cert": papers.tls_client_cert,
        f"{TLS}.client.key": papers.tls_client_key,
    }
    for name, content in given.items():
        (folder / name).write_text(content)
    with dask.config.set({name: str(folder / name) for name in given}):
        yield crew._client.scheduler.address
