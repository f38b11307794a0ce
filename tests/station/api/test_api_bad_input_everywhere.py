"""Shows that every operation of the contract refuses what is in the wrong form with a problem
document that says so: names like paths, odd queries and bodies, keys that are none any more, calls
that two servers would read in two ways.  A new operation is covered by being in the contract."""

import http.client
import json
import re
import socket
from urllib.parse import urlencode, urlsplit

import pytest
from served_station import ADMIN_KEY, Served

from station.api import contract
from station.api.bodies import STREAMED
from station.operations import utc_now
from station.store.callers import Scope, add_key, caller_of, revoke_key

CONTRACT = contract()
OPERATIONS = [
    (method.upper(), path, operation)
    for path, operations in CONTRACT["paths"].items()
    for method, operation in operations.items()
]
OPEN = {"/healthz", "/readyz"}
FILLED = {"sensor_id": "left", "rig_id": "wheel", "number": "1", "measurement_id": "1"}
NAMES_LIKE_PATHS = [
    "..%2f..%2fetc%2fpasswd",
    "%2e%2e%2fstation.sqlite",
    "....//....//etc/passwd",
    "%2fetc%2fpasswd",
    "a%00.mcap",
    "%c0%ae%c0%ae%c0%afetc",
    "%ff%fe",
    "%EF%BC%8E%EF%BC%8E%EF%BC%8Fetc",
    "%D0%B0dmin",
    "%E2%80%AEp1",
    "C:%5cwindows",
    "~root",
    "a%0d%0aSet-Cookie:x",
    "x" * 300,
    "%7B%7D",
    "-1",
]
ODD_VALUES = ["NaN", "1e400", "9" * 31, "-" + "9" * 31, "\x00", b"\xed\xa0\x80", "x" * 9000,
              "' OR 1=1 --", "../../etc/passwd"]  # fmt: skip
ODD_JSON = ["null", "true", "-1", "1.5", "1e400", "NaN", "9" * 31, "[]", "{}", '"\\u0000"',
            '"\\ud800"', '""', '"../../etc/passwd"', f'"{"x" * 9000}"',
            '{"a":{"b":{"c":[1,[2,[3]]]}}}', f"[{'0,' * 2000}0]"]  # fmt: skip
BODIES = {
    "no JSON": (b"{", "JSON"),
    "not UTF-8": (b'{"a": "\xff"}', "UTF-8"),
    "UTF-16": ('{"a": 1}'.encode("utf-16"), "UTF-8"),
    "a list": (b"[]", "body"),
    "a text": (b'"{}"', "body"),
    "nothing": (b"null", "body"),
    "deep": (b"[" * 100_000, "nested"),
    "deep and whole": (b'{"a":' * 10_000 + b"1" + b"}" * 10_000, "nested"),
    "a name twice": (b'{"a": 1, "a": 2}', "twice"),
    "NaN": (b'{"a": NaN}', "NaN"),
    "a number of 5000 digits": (b'{"a": ' + b"9" * 5000 + b"}", "digits"),
}


@pytest.fixture(scope="module")
def served(tmp_path_factory, empty_store):
    served = Served(tmp_path_factory.mktemp("bad"), empty_store, web={"bad_keys": 1000})
    yield served
    served.close()


class Caller:
    """Sends calls as they are over one connection, and judges the answers."""

    def __init__(self, served):
        address = urlsplit(served.url)
        self._connection = http.client.HTTPConnection(address.hostname, address.port, timeout=30.0)
        self._root = str(served.layout.root)

    def close(self):
        self._connection.close()

    def refused(self, method, path, **given):
        """Make a call that must be refused; return status and reason."""
        status, detail = self.made(method, path, **given)
        assert 400 <= status < 500, (method, path, given, status)
        return status, detail

    def made(self, method, path, *, body=None, headers=(), key=ADMIN_KEY):
        """Make a call that must not fail for the station; return status and the reason."""
        sent = {"Authorization": f"Bearer {key}", "Content-Type": "application/json"}
        self._connection.request(method, path, body, {**sent, **dict(headers)})
        answer = self._connection.getresponse()
        content = answer.read()
        told = (method, path[:200], answer.status, content[:500])
        assert answer.status < 500, told
        assert self._root.encode() not in content, told
        assert b"Traceback" not in content, told
        assert b"root:" not in content, told
        if answer.status < 400:
            return answer.status, None
        assert answer.getheader("Content-Type") == "application/problem+json", told
        problem = json.loads(content)
        assert problem["status"] == answer.status, told
        assert 0 < len(problem["detail"]) < 2000, told
        return answer.status, problem["detail"]


@pytest.fixture(scope="module")
def caller(served):
    caller = Caller(served)
    yield caller
    caller.close()


def filled(path, **names):
    return re.sub(r"\{(\w+)\}", lambda m: names.get(m[1]) or FILLED.get(m[1], "x1"), path)


def resolved(schema):
    while "$ref" in schema or "anyOf" in schema:
        reference = schema.get("$ref") or schema["anyOf"][0].get("$ref")
        if reference is None:
            return schema["anyOf"][0]
        schema = CONTRACT["components"]["schemas"][reference.rpartition("/")[2]]
    return schema


def body_of(operation):
    """The schema of an operation's JSON body; None where it has none."""
    content = operation.get("requestBody", {}).get("content", {})
    return (
        resolved(content["application/json"]["schema"]) if "application/json" in content else None
    )


WITH_BODY = [
    pytest.param(method, path, operation, id=f"{method} {path}")
    for method, path, operation in OPERATIONS
    if body_of(operation) is not None
]


@pytest.mark.parametrize("name", NAMES_LIKE_PATHS, ids=lambda name: name[:24])
def test_no_operation_takes_a_name_that_looks_like_a_path(served, caller, name):
    before = sorted(served.layout.root.rglob("*"))
    for method, path, operation in OPERATIONS:
        for parameter in re.findall(r"\{(\w+)\}", path):
            body = None if body_of(operation) is None else "{}"
            caller.refused(method, filled(path, **{parameter: name}), body=body)
    after = sorted(served.layout.root.rglob("*"))
    assert [file for file in after if file not in before and "sqlite" not in file.name] == []


@pytest.mark.parametrize("value", ODD_VALUES, ids=lambda value: repr(value[:12]))
def test_no_operation_fails_for_a_value_in_its_query(caller, value):
    for method, path, operation in OPERATIONS:
        for parameter in operation.get("parameters", []):
            if parameter["in"] == "query":
                query = urlencode({parameter["name"]: value})
                status, detail = caller.made(method, f"{filled(path)}?{query}")
                kind = resolved(parameter["schema"]).get("type")
                if kind in {"integer", "number", "boolean"}:
                    assert status in {404, 422}, (path, parameter["name"], value, status)
                    assert status == 404 or parameter["name"] in detail


@pytest.mark.parametrize(("method", "path", "operation"), WITH_BODY)
def test_a_body_in_no_form_is_refused_by_every_operation_and_it_says_why(
    caller, method, path, operation
):
    for what, (body, says) in BODIES.items():
        status, detail = caller.refused(method, filled(path), body=body)
        assert status in {400, 422}, (what, status)
        assert says in detail, (what, detail)
    for kind in ("text/plain", "application/xml", "multipart/form-data; boundary=x", "a/b/c", ""):
        caller.refused(method, filled(path), body=b'{"a": 1}', headers={"Content-Type": kind})
    _, detail = caller.refused(method, filled(path), body=b'{"no such field": 1}')
    assert "no such field" in detail or "more" in detail


@pytest.mark.parametrize(("method", "path", "operation"), WITH_BODY)
def test_no_field_of_a_body_makes_an_operation_fail(caller, method, path, operation):
    for name in body_of(operation)["properties"]:
        for value in ODD_JSON:
            body = f'{{"{name}": {value}}}'.encode()
            status, detail = caller.made(method, filled(path), body=body)
            if value in {"NaN", "1e400", "9" * 31} or "\\ud800" in value:
                assert 400 <= status < 500, (name, value[:40], status)
                assert detail


@pytest.mark.parametrize(("method", "path", "operation"), WITH_BODY)
def test_a_body_that_would_be_too_large_is_refused_before_it_comes(served, method, path, operation):
    head = f"{method} {filled(path)} HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer {ADMIN_KEY}\r\n"
    for length in ("Content-Length: 100000000\r\n", f"Content-Length: {'9' * 20}\r\n"):
        answer = first_answer(served, f"{head}{length}\r\n".encode())
        assert answer.startswith(b"HTTP/1.1 413"), answer
        assert b"send less" in answer


ODD_HEADERS = [
    ("If-Match", '"\xff"'),
    ("If-Match", "*"),
    ("If-Match", 'W/"1", "2"'),
    ("If-Match", "9" * 40),
    ("Range", "bytes=0-18446744073709551616"),
    ("Range", "bytes=-"),
    ("Idempotency-Key", "é" * 10),
    ("Idempotency-Key", "k" * 300),
    ("X-Request-Id", "\x1b[31m\x7f"),
    ("X-Forwarded-For", "'; DROP TABLE passes"),
    ("Accept", "image/png;q=NaN"),
    ("Expect", "the impossible"),
    ("Content-Encoding", "gzip"),
    ("Last-Event-ID", "\x00".replace("\x00", "x" * 5000)),
]


@pytest.mark.parametrize("header", ODD_HEADERS, ids=lambda header: f"{header[0]} {header[1][:8]!r}")
def test_no_operation_fails_for_an_odd_header(caller, header):
    name, value = header
    for method, path, operation in OPERATIONS:
        body = None if body_of(operation) is None else '{"no such field": 1}'
        given = {name: value.encode("latin-1", "ignore")}
        caller.made(method, filled(path), body=body, headers=given)


def test_a_key_that_is_none_any_more_opens_no_operation(served, caller):
    now = utc_now()
    with served.store.change() as session:
        expired = add_key(session, "old", [Scope.ADMIN], at=now, expires_at=now)
        revoked = add_key(session, "gone", [Scope.ADMIN], at=now)
        revoke_key(session, caller_of(session, revoked, at=now).key_id, at=now)
    for method, path, _ in OPERATIONS:
        if path in OPEN:
            continue
        for key in (expired, revoked, "tl_00000000_none"):
            status, detail = caller.refused(method, filled(path), key=key)
            assert status == 401, (method, path, status)
            assert "administrator" in detail


def test_a_key_that_may_only_read_changes_nothing_by_any_operation(served, caller):
    key = served.key(Scope.READ)
    for method, path, operation in OPERATIONS:
        if method != "GET":
            body = None if body_of(operation) is None else "{}"
            status, detail = caller.refused(method, filled(path), body=body, key=key)
            assert status == 403, (method, path, status)
            assert "this call needs" in detail


CHUNKED = b"0\r\n\r\n"
HIDDEN = b"GET /v1/station HTTP/1.1\r\nHost: x\r\n\r\n"
IN_TWO_WAYS = {
    "both lengths": b"Content-Length: 5\r\nTransfer-Encoding: chunked\r\n\r\n" + CHUNKED + HIDDEN,
    "two lengths": b"Content-Length: 0\r\nContent-Length: 37\r\n\r\n" + HIDDEN,
    "a list of lengths": b"Content-Length: 0, 37\r\n\r\n" + HIDDEN,
    "a length with a sign": b"Content-Length: +37\r\n\r\n" + HIDDEN,
    "a length in hexadecimal": b"Content-Length: 0x25\r\n\r\n" + HIDDEN,
    "a space before the colon": b"Transfer-Encoding : chunked\r\n\r\n" + CHUNKED + HIDDEN,
    "two codings": b"Transfer-Encoding: gzip, chunked\r\n\r\n" + CHUNKED + HIDDEN,
    "a coding that is none": b"Transfer-Encoding: xchunked\r\n\r\n" + CHUNKED + HIDDEN,
    "a chunk of any size": b"Transfer-Encoding: chunked\r\n\r\n" + b"F" * 40 + b"\r\n" + HIDDEN,
    "a chunk of no size": b"Transfer-Encoding: chunked\r\n\r\nzz\r\n" + HIDDEN,
    "two hosts": b"Host: y\r\nContent-Length: 0\r\n\r\n" + HIDDEN,
}


@pytest.mark.parametrize("what", IN_TWO_WAYS)
def test_a_call_that_can_be_read_in_two_ways_is_refused_and_nothing_after_it_read(served, what):
    head = (
        f"PUT /v1/passes/p1 HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer {ADMIN_KEY}\r\n".encode()
    )
    answers = every_answer(served, head + IN_TWO_WAYS[what])
    assert answers.startswith((b"HTTP/1.1 400", b"HTTP/1.1 501")), answers
    assert len(re.findall(rb"HTTP/1\.1 \d", answers)) == 1
    assert b"application/problem+json" in answers


def first_answer(served, content):
    with connected(served) as connection:
        connection.sendall(content)
        answer = b""
        while not answer.endswith(b"}"):
            piece = connection.recv(65536)
            assert piece, answer
            answer += piece
        return answer


def every_answer(served, content):
    with connected(served) as connection:
        connection.sendall(content)
        connection.shutdown(socket.SHUT_WR)
        answers = b""
        while piece := connection.recv(65536):
            answers += piece
        return answers


def connected(served):
    address = urlsplit(served.url)
    return socket.create_connection((address.hostname, address.port), timeout=30.0)


def test_operations_that_read_their_body_themselves_are_few_and_tested_apart():
    assert {("POST", "/v1/recordings")} == set(STREAMED)
