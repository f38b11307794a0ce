"""The example of a proxy, read by Debian's nginx as it is, before a station that runs.

Not shown: what a browser makes of it, and a certificate that others believe.
"""

import json
import os
import signal

import httpx
import numpy as np
import pytest
from behind_proxy import CALLER_AT, NAME, NGINX, Proxy, a_station

from station.recording import RecordingWriter

LARGEST_UPLOAD = 2_000_000  # as `upload_mb` of its settings
NGINX_TAKES_BY_ITSELF = 1 << 20


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A station and the proxy before it: proxy, key, process id of the worker."""
    if NGINX is None:
        pytest.skip("no nginx here; deploy/test installs it")
    folder = tmp_path_factory.mktemp("proxied")
    with a_station(folder) as (port, worker):
        proxy = Proxy(folder, port)
        yield proxy, (folder / "data/first-admin-key").read_text().strip(), worker
        proxy.close()


@pytest.fixture(scope="module")
def proxy(run):
    return run[0]


@pytest.fixture(scope="module")
def call(run):
    proxy, key, _ = run
    with proxy.client(key) as client:
        yield client


@pytest.fixture(scope="module")
def uploaded(call, tmp_path_factory):
    """The answer to a recording larger than nginx would take by itself."""
    file = tmp_path_factory.mktemp("recorded") / "left.mcap"
    picture = np.random.default_rng(1).integers(0, 255, (1200, 1500), np.uint8)
    with RecordingWriter(file) as writer:
        writer.write_frame("left", 1, 1, 1, picture.data, 1500, 1200)
    content = file.read_bytes()
    assert NGINX_TAKES_BY_ITSELF < len(content) <= LARGEST_UPLOAD
    return upload(call, content)


def upload(call, content):
    said = {"Content-Type": "application/octet-stream", "X-Forwarded-For": "10.9.8.7"}
    return call.post("/v1/recordings", content=content, headers=said)


def test_a_call_with_a_key_is_answered_with_the_headers_of_an_encrypted_station(call):
    reply = call.get("/v1/station")
    assert reply.status_code == 200
    assert reply.headers["Strict-Transport-Security"] == "max-age=31536000"
    assert "default-src 'none'" in reply.headers["Content-Security-Policy"]


def test_a_browser_logs_in_and_its_cookie_is_of_this_host_alone_and_encrypted(run):
    proxy, key, _ = run
    with proxy.client() as browser:
        assert browser.get("/now", headers={"Accept": "text/html"}).is_redirect
        page = browser.get("/login")
        assert "script-src 'self'" in page.headers["Content-Security-Policy"]
        reply = browser.post(
            "/login", data={"key": key}, headers={"Origin": f"https://{NAME}"}
        )  # as a browser sends a form
        assert (reply.status_code, reply.headers["Location"]) == (303, "/now")
        cookie = reply.headers["Set-Cookie"]
        assert cookie.startswith("__Host-treadline=")
        assert "; Secure" in cookie
        assert browser.get("/now").status_code == 200


def test_a_form_of_another_host_logs_nobody_in(run):
    proxy, key, _ = run
    with proxy.client() as browser:
        reply = browser.post("/login", data={"key": key}, headers={"Origin": "https://elsewhere"})
    assert (reply.status_code, "Set-Cookie" in reply.headers) == (401, False)


def test_the_station_knows_who_calls_whatever_the_caller_says(call, uploaded):
    assert uploaded.status_code == 201
    entries = call.get("/v1/audit").json()["entries"]
    assert [each["address"] for each in entries if each["kind"] == "recording"] == [CALLER_AT]


def test_a_recording_passes_that_is_larger_than_nginx_takes_by_itself(uploaded):
    assert uploaded.status_code == 201
    assert uploaded.json()["recorded"] == 1


def test_it_is_the_station_that_says_how_large_a_recording_may_be(call):
    reply = upload(call, b"\x89MCAP0\r\n" + bytes(LARGEST_UPLOAD))
    assert reply.status_code == 422
    assert "at most 2 MB" in reply.json()["detail"]


def test_an_event_comes_while_its_job_still_waits(run, call, uploaded):
    worker = run[2]
    os.kill(worker, signal.SIGSTOP)
    try:
        order = {"sensor": "left", "recordings": [uploaded.json()["id"]], "target": "dots:7x8:12"}
        job = call.post("/v1/calibrations", json=order).headers["Location"]
        with call.stream("GET", f"{job}/events") as events:
            lines = events.iter_lines()
            first = next(line for line in lines if line.startswith("data:"))
            os.kill(worker, signal.SIGCONT)
            last = [line for line in lines if line.startswith("data:")][-1]
    finally:
        os.kill(worker, signal.SIGCONT)
    assert json.loads(first[5:])["state"] == "queued"
    assert json.loads(last[5:])["state"] == "failed"  # its picture shows no target


def test_a_page_asked_for_unencrypted_is_led_to_the_encrypted_one(proxy):
    reply = proxy.plainly("GET", "/passes?train=7")
    assert reply.status_code == 308
    assert reply.headers["Location"] == f"https://{NAME}/passes?train=7"


def test_a_program_that_calls_unencrypted_is_told_and_not_led_on(proxy):
    reply = proxy.plainly("PUT", "/v1/passes/p1")
    assert reply.status_code == 403
    assert reply.text.endswith(f"call https://{NAME}\n")


def test_who_names_another_host_gets_no_answer(proxy):
    with pytest.raises(httpx.RemoteProtocolError):
        proxy.plainly("GET", "/", host="127.73.0.3")
    stranger = proxy.client(host="elsewhere.example")
    with stranger, pytest.raises(httpx.ConnectError, match="UNRECOGNIZED_NAME"):
        stranger.get("/")
