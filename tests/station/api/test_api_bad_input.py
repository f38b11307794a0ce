"""Shows that whatever comes in the wrong form is refused with a reason, and holds up nobody: large,
slow, broken, deep and misspelt bodies, headers that never end, names that look like paths."""

import json
import select
import socket
import time
from contextlib import suppress

import pytest

PASS = "/v1/passes/p1"
AS_JSON = {"Content-Type": "application/json"}
PATIENCE_S = 60.0
IMPATIENT = pytest.mark.parametrize(
    "served", [{"web": {"header_s": 0.3, "body_s": 0.3}}], indirect=True
)


@pytest.mark.parametrize(
    ("body", "status", "says"),
    [
        (b'{"train": "' + b"x" * 200 + b'"}', 422, "128 characters"),
        (b'{"train": "a\\u0000b"}', 422, "pattern"),
        (b'{"train": "\\ud800"}', 422, "train"),
        (b'{"train": "\xff"}', 400, "not UTF-8 (byte 11)"),
        (b'{"train": "x"}'.decode().encode("utf-16"), 400, "not UTF-8"),
        (b'{"train": NaN}', 400, "NaN"),
        (b'{"train": 1e999}', 422, "train"),
        (b'{"train": ' + b"9" * 5000 + b"}", 400, "4300 digits"),
        (b"[" * 100_000, 400, "nested"),
        (b"[" * 40 + b"]" * 40, 400, "nested deeper than 32"),
        (b'{"consist":' * 40 + b"1" + b"}" * 40, 400, "nested deeper than 32"),
        (json.dumps({f"f{n}": n for n in range(10_000)}).encode(), 422, "and 9995 more"),
        (json.dumps({"consist": ["w"] * 1001}).encode(), 422, "1000"),
        (b"null", 422, "body"),
        (b'"text"', 422, "body"),
        (b"", 422, "body"),
        (b'{"train": "x"} trailing', 422, "JSON"),
    ],
    ids=lambda value: repr(value[:24]) if isinstance(value, bytes) else None,
)
def test_a_body_that_is_not_what_it_should_be_is_refused_with_a_short_reason(
    served, call, body, status, says
):
    reply = call.put(PASS, content=body, headers=AS_JSON)
    assert reply.status_code == status, reply.text
    assert says in reply.json()["detail"]
    assert len(reply.content) < 3000
    assert served.captures["left"].plans == []


@pytest.mark.parametrize("kind", [None, "text/plain", "application/xml", "multipart/form-data"])
def test_a_body_of_another_kind_is_refused(call, kind):
    headers = {} if kind is None else {"Content-Type": kind}
    reply = call.put(PASS, content=b'{"train": "x"}', headers=headers)
    assert 400 <= reply.status_code < 500
    assert reply.headers["content-type"] == "application/problem+json"


def test_a_body_that_says_it_is_too_large_is_refused_before_it_is_sent(served):
    reply = raw(served, f"PUT {PASS} HTTP/1.1\r\n", f"Content-Length: {100 * 10**6}\r\n")
    assert reply.startswith("HTTP/1.1 413")
    assert "1024000 bytes at most" in reply


def test_a_hundred_megabytes_sent_all_the_same_are_refused_and_the_caller_is_told(call):
    body = b"x" * (100 * 10**6)
    began_s = time.monotonic()
    reply = call.put(PASS, content=body, headers=AS_JSON)
    assert reply.status_code == 413
    # They are read and dropped for two seconds at most, so that the answer is not lost.
    assert time.monotonic() - began_s < PATIENCE_S


def test_the_rest_of_a_refused_body_is_dropped_for_a_while_and_no_longer(served):
    host, port = served.url.removeprefix("http://").split(":")
    key = served.client().headers["Authorization"]
    head = f"PUT {PASS} HTTP/1.1\r\nHost: x\r\nAuthorization: {key}\r\nContent-Length: {10**9}\r\n"
    with socket.create_connection((host, int(port)), timeout=PATIENCE_S) as connection:
        connection.sendall(f"{head}\r\n".encode())
        assert b" 413 " in connection.recv(10_000)
        began_s = time.monotonic()
        for _ in range(4):
            # To a connection that was closed at once the second of these would fail.
            connection.sendall(b"x" * 1000)
            time.sleep(0.1)
        while connection.recv(10_000):
            pass
        assert 1.0 < time.monotonic() - began_s < PATIENCE_S


def test_a_body_of_unsaid_length_is_cut_off_where_it_gets_too_large(call):
    reply = call.put(PASS, content=(b"x" * 100_000 for _ in range(50)), headers=AS_JSON)
    assert reply.status_code == 413


@IMPATIENT
def test_a_body_that_does_not_come_is_408(served):
    reply = raw(served, f"PUT {PASS} HTTP/1.1\r\n", "Content-Length: 20\r\n", body="{")
    assert reply.startswith("HTTP/1.1 408")
    assert "not whole after 0.3 s" in reply


@IMPATIENT
def test_headers_that_do_not_end_are_408_and_hold_no_connection(served):
    address = served.url.removeprefix("http://").split(":")
    began_s = time.monotonic()
    with socket.create_connection((address[0], int(address[1])), timeout=PATIENCE_S) as connection:
        # A letter whenever nothing has come for a while: were it counted from the last one, nothing
        # ever would.
        while not select.select([connection], [], [], 0.05)[0]:
            assert time.monotonic() - began_s < PATIENCE_S
            with suppress(ConnectionError):  # closed since
                connection.sendall(b"x")
        reply = connection.recv(10_000).decode()
        with suppress(ConnectionError):  # a letter came too late
            assert connection.recv(10_000) == b""
    assert reply.startswith("HTTP/1.1 408")
    assert "application/problem+json" in reply


@IMPATIENT
def test_a_caller_who_sends_a_second_call_drop_by_drop_is_cut_off_too(served):
    address = served.url.removeprefix("http://").split(":")
    with socket.create_connection((address[0], int(address[1])), timeout=PATIENCE_S) as connection:
        connection.sendall(b"GET /healthz HTTP/1.1\r\nHost: x\r\n\r\nGET /hea")
        reply = b""
        while piece := connection.recv(10_000):
            reply += piece
    assert reply.count(b"HTTP/1.1 200") == 1
    assert reply.count(b"HTTP/1.1 408") == 1


@pytest.mark.parametrize("served", [{"web": {"connections": 4}}], indirect=True)
def test_one_address_cannot_hold_all_connections(served):
    host, port = served.url.removeprefix("http://").split(":")
    held = [socket.create_connection((host, int(port)), timeout=PATIENCE_S) for _ in range(5)]
    try:
        reply = held[-1].recv(10_000).decode()
        assert reply.startswith("HTTP/1.1 503")
        assert "you hold 4 connections" in reply
        held[0].sendall(b"GET /healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n")
        assert held[0].recv(10_000).startswith(b"HTTP/1.1 200")
        held[0].close()
        began_s = time.monotonic()
        # That it is gone reaches the station a moment later.
        while not raw(served, "GET /healthz HTTP/1.1\r\n").startswith("HTTP/1.1 200"):
            assert time.monotonic() - began_s < PATIENCE_S
    finally:
        for connection in held:
            connection.close()


@pytest.mark.parametrize(
    "lines",
    [
        "rubbish\r\n\r\n",
        "GET / HTTP/1.1\r\nno colon\r\n\r\n",
        "GET / HTTP/1.1\r\nX: " + "x" * 100_000,
        "GET / HTTP/1.1\r\nContent-Length: -1\r\n\r\n",
    ],
    ids=["no request", "no header", "endless header", "negative length"],
)
def test_what_is_no_http_is_400_as_a_problem_document(served, lines):
    reply = raw_text(served, lines)
    assert reply.startswith("HTTP/1.1 400")
    assert json.loads(reply.partition("\r\n\r\n")[2])["status"] == 400


TRICKS = [
    "..",
    "%2e%2e",
    "..%2f..%2fetc%2fpasswd",
    "%2fetc%2fpasswd",
    "....//etc",
    "a%00b",
    "a%0ab",
    "~root",
    "C:%5cwindows",
    "%ff%fe",
    "a b",
    "%EF%BC%8E%EF%BC%8E",
    "station.sqlite%00.mcap",
]
PLACES = [
    ("PUT", "/v1/passes/{}"),
    ("GET", "/v1/passes/{}/wheels"),
    ("PUT", "/v1/calibration-sessions/{}"),
    ("GET", "/v1/calibrations/{}/points"),
    ("GET", "/v1/rig-calibrations/{}"),
    ("GET", "/v1/rigs/{}/active-calibration"),
    ("GET", "/v1/sensors/{}/active-calibration"),
    ("GET", "/v1/jobs/{}/events"),
    ("GET", "/v1/recordings/{}"),
    ("DELETE", "/v1/recordings/{}"),
    ("GET", "/v1/wheelsets/{}/trend"),
]


@pytest.mark.parametrize("trick", TRICKS)
def test_a_name_that_looks_like_a_path_is_refused_everywhere(served, trick, tmp_path):
    for method, place in PLACES:
        body = '{"sensor": "left", "target": "dots:7x8:12"}' if "session" in place else "{}"
        start = f"{method} {place.format(trick).replace(' ', '%20')} HTTP/1.1\r\n"
        reply = raw(served, start, f"Content-Length: {len(body)}\r\n", body=body)
        assert reply.split()[1] in {"404", "405", "422"}, (method, place, reply)
        assert "root:" not in reply
    made = [path.name for path in tmp_path.rglob("*") if not path.name.startswith("station.sqlite")]
    assert made == []


@pytest.mark.parametrize("name", ["../../etc/passwd", "/etc/passwd", "a\x00b", "x" * 200, ""])
def test_a_recording_is_named_and_never_pointed_at(call, name):
    order = {"sensor": "left", "recordings": [name], "target": "dots:7x8:12"}
    assert call.post("/v1/calibrations", json=order).status_code == 422


@pytest.mark.parametrize(
    "before",
    [
        "0001-01-01T00:00:00+14:00 a",
        "2026-07-01T12:00:00+00:00 a\x00",
        "2026-07-01T12:00:00+00:00",
        "x",
        "9999-12-31T23:59:59-14:00 a",
    ],
)
def test_a_place_in_a_list_that_is_none_is_refused(call, before):
    reply = call.get("/v1/recordings", params={"before": before})
    assert reply.status_code == 422
    assert "`next` of a page" in reply.json()["detail"]


def test_a_method_that_an_address_has_not_is_told_those_it_has(call):
    assert call.post(PASS).headers["Allow"] == "GET, PUT"
    assert call.put("/v1/recordings").headers["Allow"] == "GET, POST"


def raw(served, *lines, body=""):
    key = served.client().headers["Authorization"]
    head = "".join(lines) + f"Host: x\r\nAuthorization: {key}\r\nContent-Type: application/json\r\n"
    return raw_text(served, f"{head}Connection: close\r\n\r\n{body}")


def raw_text(served, text):
    """Send text as it is, and return everything that comes back."""
    host, port = served.url.removeprefix("http://").split(":")
    with socket.create_connection((host, int(port)), timeout=PATIENCE_S) as connection:
        connection.sendall(text.encode())
        reply = b""
        while piece := connection.recv(65536):
            reply += piece
    return reply.decode()
