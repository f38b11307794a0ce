"""Shows what an answered call leaves in the log, and how its lines are found again."""

import json
import socket

import pytest
from served_station import ADMIN_KEY

from station.serve import log_as


@pytest.fixture
def lines(call, capfd):
    """The lines of the log, as they are when asked for."""
    taken = []

    def read():
        # A line follows its answer: with a next answer there, it has been written.
        call.get("/healthz")
        text = capfd.readouterr().err
        taken.extend(json.loads(line) for line in text.splitlines() if line.startswith("{"))
        return taken

    return read


def answered(lines):
    return [line for line in lines if line["event"] == "answered"]


@pytest.fixture
def at_debug():
    log_as("test", "debug")
    yield
    log_as("test")


def test_a_change_is_one_line_with_who_what_and_how_long(served, call, lines):
    call.put("/v1/passes/p1", json={})
    (line,) = answered(lines())
    assert (line["method"], line["route"], line["pass"]) == ("PUT", "/v1/passes/{pass_id}", "p1")
    assert (line["status"], line["who"], line["address"]) == (201, "environment", "127.0.0.1")
    assert line["ms"] > 0
    assert line["level"] == "info"


def test_a_read_that_succeeds_is_told_at_debug_alone_and_a_probe_never(
    served, call, lines, at_debug
):
    call.get("/v1/station")
    call.get("/healthz")
    call.get("/readyz")
    (line,) = answered(lines())
    assert (line["path"], line["level"]) == ("/v1/station", "debug")
    log_as("test")
    call.get("/v1/station")
    call.get("/v1/passes/none")
    assert [line["path"] for line in answered(lines())[1:]] == ["/v1/passes/none"]


def test_the_callers_own_id_names_the_answer_the_problem_and_every_line_of_the_call(
    served, call, lines
):
    served.captures["left"].broken = "no camera answers"
    given = {"X-Request-Id": "plc-7.42"}
    answer = call.put("/v1/passes/p1", json={}, headers=given)
    assert answer.status_code == 503
    assert answer.headers["X-Request-Id"] == answer.json()["request"] == "plc-7.42"
    of_call = [line for line in lines() if line.get("request") == "plc-7.42"]
    # Closing what was armed runs in threads of its own, and names the call all the same.
    assert {"recording closed", "answered"} <= {line["event"] for line in of_call}
    assert {line["pass"] for line in of_call} == {"p1"}


@pytest.mark.parametrize("given", ["", "a b", "x" * 65, '"}{"', "é"])
def test_an_id_that_cannot_be_logged_is_replaced(call, given):
    answer = call.get("/v1/passes/none", headers={b"X-Request-Id": given.encode()})
    made = answer.headers["X-Request-Id"]
    assert made != given
    assert len(made) == 12
    assert answer.json()["request"] == made


def test_an_error_nobody_foresaw_is_found_by_its_id_and_keeps_the_headers(
    served, call, lines, monkeypatch
):
    def explode():
        raise RuntimeError("secret of the inside")

    monkeypatch.setattr(served.captures["left"], "status", explode)
    answer = call.get("/v1/station")
    assert answer.headers["X-Content-Type-Options"] == "nosniff"
    found = [line for line in lines() if line.get("request") == answer.json()["request"]]
    (failed,) = [line for line in found if line["event"] == "request failed unexpectedly"]
    assert "secret of the inside" in failed["exception"]
    assert answered(found)[0]["level"] == "warning"


def test_no_key_is_logged_good_or_bad_wherever_it_is_put(served, call, lines, at_debug):
    bad = "tl_0123abcd_" + "S" * 43
    with served.client(bad) as client:
        client.get("/v1/station")
        client.get(f"/v1/passes/{bad}", headers={"X-Request-Id": bad[:64]})
        client.get(f"/v1/passes?key={bad}")
    call.get(f"/v1/jobs/{bad}")
    text = json.dumps(lines())
    assert "S" * 8 not in text
    assert "tl_0123abcd_***" in text
    assert ADMIN_KEY not in text


def test_a_job_leads_to_the_call_that_ordered_it(served, call, lines):
    """The line of the real queue; the one of the served station is a double."""
    from station.log_ids import about  # noqa: PLC0415  beside its only use
    from station.store import JobKind  # noqa: PLC0415  as above
    from station.worker import WorkerQueue  # noqa: PLC0415  as above

    queue = WorkerQueue(served.layout.jobs_url)

    class Client:
        def enqueue(self, *_):
            pass

    queue.__dict__["_client"] = Client()
    with about(request="r1", pass_id="p1"):
        queue.submit(JobKind.MEASURE, "j1")
    (line,) = [line for line in lines() if line["event"] == "job ordered"]
    assert (line["job"], line["kind"], line["request"], line["pass"]) == (
        "j1",
        "measure",
        "r1",
        "p1",
    )


def test_what_the_server_itself_says_is_a_line_like_all_others(served, lines):
    place = ("127.0.0.1", int(served.url.rpartition(":")[2]))
    with socket.create_connection(place, timeout=20.0) as connection:
        connection.sendall(b"no call of HTTP\r\n\r\n")
        connection.recv(1000)
    (said,) = [line for line in lines() if line.get("logger") == "uvicorn.error"]
    assert "Invalid HTTP request" in said["event"]
    assert (said["level"], said["process"]) == ("warning", "test")


def test_a_trouble_is_logged_when_it_comes_and_names_no_call(served, call, lines):
    call.get("/v1/station")
    found = [line for line in lines() if line["event"] == "trouble"]
    missing = {line["part"] for line in found if line["kind"] == "calibration_missing"}
    assert missing == {"sensor left", "sensor right"}
    assert not any("request" in line for line in found)
