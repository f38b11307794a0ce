"""A Dask cluster of this machine's cores, or one that somebody else runs."""

import logging
import tempfile
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from station.errors import InputUnusable
from station.replay.crew import Workers
from station.software import SOFTWARE

_PACKAGE = "treadline"
_TLS = "distributed.comm.tls"
_CONNECT_S, _START_S = 10, 120
_USUAL_START_S = 5.0
"""What it takes workers of this machine to start, about."""
_MEMORY_BYTES = 1 << 30
"""Of a worker: more than twice what one takes, and few enough for all cores of a small machine."""
_LOCAL_CONFIG = {
    # A recording that kills two workers is suspected, and is named when it kills two more.
    "distributed.scheduler.allowed-failures": 1,
    # Nobody reads these lines: a task of minutes that holds the interpreter is no fault here.
    "distributed.admin.tick.limit": "1h",
    # Its own watching takes a twentieth of a core.
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.worker.preload": ["station.replay.worker_start"],
    "distributed.comm.timeouts.connect": "30s",
    # Its pages would tell whoever asks on this machine what is measured.
    "distributed.scheduler.http.routes": [],
    "distributed.worker.http.routes": [],
}


def sooner_by_workers(alone_s: float, count: int) -> bool:
    """Tell whether so many workers of this machine, to be started, are sooner done than one."""
    return count > 1 and alone_s > alone_s / count + _USUAL_START_S


@contextmanager
def local_workers(count: int) -> Generator[Workers]:
    """Give work to processes of this machine, a thread each, that end with the block and with this.

    They listen on the loopback alone, without a page, and talk to nobody who has not the key that
    is made for them and kept in memory: what speaks to them may have them run whatever it likes.
    """
    import dask  # noqa: PLC0415  costs 0.5 s: only where it is used
    from distributed import Client, LocalCluster  # noqa: PLC0415  see the line above
    from distributed.security import Security  # noqa: PLC0415  see the line above

    with (
        tempfile.TemporaryDirectory(prefix="treadline-replay-") as scratch,
        dask.config.set(_LOCAL_CONFIG),
        LocalCluster(
            n_workers=count,
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            security=Security.temporary(),
            scheduler_kwargs={"dashboard": False},
            dashboard_address="127.0.0.1:0",  # any free port: a second replay has its own
            memory_limit=_MEMORY_BYTES,
            local_directory=scratch,
            silence_logs=logging.CRITICAL,
        ) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        client.wait_for_workers(count, timeout=_START_S)

        def refill() -> None:
            # Dask starts a worker that died, but not one that died while it was starting.
            cluster.scale(count)

        yield Workers(client, refill)


@contextmanager
def workers_at(address: str) -> Generator[Workers]:
    """Give work to the workers of a scheduler, which go on when the block ends.

    What it takes to speak to a scheduler at tls:// is in Dask's own configuration.

    Raises
    ------
    InputUnusable
        If there is no scheduler at the address, or none that trusts this and is trusted, it has no
        worker, or one has other software.
    """
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    with _connected(address) as client:
        _ensure_same_software(address, client)
        yield Workers(client)


def _connected(address: str) -> Any:
    from distributed import Client  # noqa: PLC0415  costs 0.5 s: only where it is used
    from distributed.comm.core import FatalCommClosedError  # noqa: PLC0415  see the line above

    try:
        return Client(
            address, security=_own_papers(address), timeout=_CONNECT_S, set_as_default=False
        )
    except FatalCommClosedError as error:
        raise InputUnusable(
            f"cluster {address}: its certificate is not of the authority in Dask's configuration; "
            f"give the one that signed it as {_TLS}.ca-file"
        ) from error
    except (OSError, ValueError) as error:
        raise InputUnusable(
            f"cluster {address}: no Dask scheduler answers there; give the address that "
            "`dask scheduler` prints, as tcp://HOST:8786 or tls://HOST:8786"
        ) from error
    except RuntimeError as error:
        raise InputUnusable(f"cluster {address}: {error}; give one at tls://") from error


def _own_papers(address: str) -> Any:
    """Return what this shows to a scheduler and asks of it, as Dask's configuration has it."""
    from distributed.security import Security  # noqa: PLC0415  as above

    papers = Security()
    wanted = f"{_TLS}.ca-file, .client.cert and .client.key in Dask's configuration"
    try:
        context = papers.get_connection_args("client")["ssl_context"]
    except OSError as error:  # a missing file, or one that is no certificate
        raise InputUnusable(
            f"cluster {address}: certificate not usable ({error}); look at {wanted}"
        ) from error
    if context is None and address.startswith("tls://"):
        raise InputUnusable(f"cluster {address}: there is no certificate to show it; set {wanted}")
    return papers


def _ensure_same_software(address: str, client: Any) -> None:
    found: Mapping[str, Any] = client.run(version, _PACKAGE, on_error="return")
    if not found:
        raise InputUnusable(f"cluster {address}: it has no worker; start some")
    for worker, told in sorted(found.items()):
        runs = f"no {_PACKAGE}" if isinstance(told, PackageNotFoundError) else f"{_PACKAGE} {told}"
        if runs != SOFTWARE:
            raise InputUnusable(
                f"cluster {address}: worker {worker} has {runs}, this is {SOFTWARE}; "
                "install the same on all"
            )
