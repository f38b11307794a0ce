"""Who may speak to workers, and which clusters are refused; what workers do is shown elsewhere."""

import asyncio

import crew_tasks
import dask
import httpx
import pytest
from distributed.comm import CommClosedError, connect
from distributed.comm.core import FatalCommClosedError
from distributed.security import Security

import station.replay.cluster as replay_cluster
from station.errors import InputUnusable
from station.replay.cluster import workers_at

TLS = "distributed.comm.tls"


def speak_to(address, papers=None):
    async def greet():
        known = {} if papers is None else papers.get_connection_args("client")
        comm = await connect(address, timeout=5, **known)
        await comm.close()

    asyncio.run(greet())


def every_address(workers):
    return [workers._client.scheduler.address, *workers._client.nthreads()]


def test_workers_and_scheduler_speak_to_nobody_without_their_key(workers):
    strangers = Security.temporary()
    for address in every_address(workers):
        speak_to(address, workers._client.security)
        with pytest.raises(FatalCommClosedError, match="certificate does not match"):
            speak_to(address, strangers)
        with pytest.raises((CommClosedError, OSError)):
            speak_to(address.replace("tls://", "tcp://"))


@pytest.mark.parametrize("page", ["metrics", "json/counts.json", "info/main/workers.html"])
def test_workers_and_scheduler_show_nobody_what_they_do(workers, page):
    told = workers._client.scheduler_info()
    workers_too = [one["services"]["dashboard"] for one in told["workers"].values()]
    for port in (workers._client.cluster.scheduler.http_server.port, *workers_too):
        assert httpx.get(f"http://127.0.0.1:{port}/{page}").status_code == 404


@pytest.mark.parametrize(
    "address", ["tcp://127.72.0.1:9", "tls://127.72.0.1:9", "carrier-pigeon://home"]
)
@pytest.mark.usefixtures("cluster")
def test_a_scheduler_that_is_not_there_is_one_line(monkeypatch, address):
    monkeypatch.setattr(replay_cluster, "_CONNECT_S", 1)
    refusal = pytest.raises(InputUnusable, match="no Dask scheduler answers there")
    with refusal as refused, workers_at(address):
        pass
    assert "\n" not in str(refused.value)


def test_a_scheduler_at_tls_takes_the_certificates_of_dasks_own_configuration(cluster):
    with workers_at(cluster) as crew:
        found = sorted((one.task, one.result) for one in crew.each(crew_tasks.double, range(2)))
    assert found == [(0, 0), (1, 2)]


def test_a_scheduler_of_another_authority_is_one_line(cluster, tmp_path):
    (tmp_path / "other.pem").write_text(Security.temporary().tls_ca_file)
    refusal = pytest.raises(InputUnusable, match="not of the authority in Dask's configuration")
    other = dask.config.set({f"{TLS}.ca-file": str(tmp_path / "other.pem")})
    with other, refusal, workers_at(cluster):
        pass


@pytest.mark.parametrize(
    ("named", "message"), [(None, "no certificate to show it"), ("away.pem", "not usable")]
)
def test_a_scheduler_at_tls_without_certificates_is_one_line(named, message):
    given = {f"{TLS}.{name}": named for name in ("ca-file", "client.cert", "client.key")}
    refusal = pytest.raises(InputUnusable, match=message)
    with dask.config.set(given), refusal as refused, workers_at("tls://127.72.0.1:9"):
        pass
    assert f"{TLS}.ca-file, .client.cert and .client.key" in str(refused.value)


def test_a_cluster_without_encryption_is_refused_where_dask_is_told_to_have_it(monkeypatch):
    monkeypatch.setattr(replay_cluster, "_CONNECT_S", 1)
    refusal = pytest.raises(InputUnusable, match="encryption required")
    told = dask.config.set({"distributed.comm.require-encryption": True})
    with told, refusal, workers_at("tcp://127.72.0.1:9"):
        pass


def test_workers_of_another_version_are_refused_before_any_work(monkeypatch, cluster):
    monkeypatch.setattr(replay_cluster, "SOFTWARE", "treadline 9.9")
    refusal = pytest.raises(InputUnusable, match=r"has treadline .*, this is treadline 9\.9")
    with refusal, workers_at(cluster):
        pass
