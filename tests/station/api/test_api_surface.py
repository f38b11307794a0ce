"""Shows what holds for every operation: keys and scopes, problems, headers, health, docs."""

import json
import re
import threading

import pytest

from station import errors
from station.api.contract import contract_of
from station.api.problems import STATUS_OF, status_of
from station.errors import InputUnusable
from station.store import JobKind, JobState, add_job, end, report_progress, start, the
from station.store.callers import Scope
from station.store.tables import Job

OPEN = {"/healthz", "/readyz"}


def operations(app):
    for path, methods in app.openapi()["paths"].items():
        for method in methods:
            yield method.upper(), path


def filled(path):
    names = {"pass_id": "p1", "session_id": "s1", "sensor_id": "left", "rig_id": "wheel"}
    return re.sub(r"\{(\w+)\}", lambda found: names.get(found[1], "1"), path)


def test_without_a_key_everything_but_health_is_closed(served):
    with served.client(key=None) as client:
        hidden = [("GET", "/docs"), ("GET", "/openapi.json"), ("GET", "/nowhere")]
        for method, path in [*operations(served.app), *hidden]:
            reply = client.request(method, filled(path), json={})
            assert (reply.status_code == 401) == (path not in OPEN), (method, path)
            if path not in OPEN:
                assert reply.headers["WWW-Authenticate"].startswith("Bearer")


@pytest.mark.parametrize("key", ["wrong", "tl_00000000_x", "a b", "ключ".encode()])
def test_a_key_that_is_none_is_refused(served, key):
    header = b"Bearer " + (key if isinstance(key, bytes) else key.encode())
    with served.client(key=None) as client:
        reply = client.get("/v1/station", headers={b"Authorization": header})
    assert reply.status_code == 401


def test_a_scope_opens_its_own_operations_only(served):
    needed = {
        ("PUT", "/v1/passes/p1"): Scope.OPERATE,
        ("POST", "/v1/passes/p1/finish"): Scope.OPERATE,
        ("DELETE", "/v1/jobs/j"): Scope.OPERATE,
        ("PUT", "/v1/calibration-sessions/s1"): Scope.CALIBRATE,
        ("POST", "/v1/calibrations"): Scope.CALIBRATE,
        ("PUT", "/v1/sensors/left/active-calibration"): Scope.CALIBRATE,
        ("POST", "/v1/rig-calibrations"): Scope.CALIBRATE,
        ("POST", "/v1/rig-calibrations/files"): Scope.CALIBRATE,
        ("PUT", "/v1/rigs/wheel/active-calibration"): Scope.CALIBRATE,
        ("GET", "/v1/station"): Scope.READ,
        ("GET", "/metrics"): Scope.READ,
    }
    opens = {
        Scope.READ: {Scope.READ},
        Scope.OPERATE: {Scope.READ, Scope.OPERATE},
        Scope.CALIBRATE: {Scope.READ, Scope.CALIBRATE},
        Scope.ADMIN: set(Scope),
    }
    for held, opened in opens.items():
        with served.client(served.key(held)) as client:
            for (method, path), scope in needed.items():
                # A body that none takes: a call that passes the gate changes nothing.
                reply = client.request(method, path, json={"unknown": 1})
                assert (reply.status_code != 403) == (scope in opened), (held, method, path)


def test_a_short_key_from_the_environment_is_refused(served):
    from station.api import build_app

    with pytest.raises(InputUnusable, match="7 characters"):
        build_app(served.station, admin_key="letmein", worker_ready=lambda: True)


def every_error(cls=errors.StationError):
    yield cls
    for sub in cls.__subclasses__():
        yield from every_error(sub)


def test_every_error_of_the_station_has_a_status_and_is_drawn_in_the_tree():
    for cls in every_error():
        if cls.__module__ == errors.__name__:
            assert any(base in STATUS_OF for base in cls.__mro__)
            assert cls.__name__ in errors.__doc__
    assert status_of(errors.CameraLost("x")) == 503


@pytest.mark.parametrize(
    ("method", "path", "content", "status", "says"),
    [
        ("PUT", "/v1/passes/p1", '{"train": 5}', 422, "train"),
        ("PUT", "/v1/passes/p1", '{"trian": "x"}', 422, "trian"),
        ("PUT", "/v1/passes/p1", "{", 422, "JSON"),
        ("PUT", "/v1/passes/p1", b"\xff\xfe", 400, "UTF-8"),
        ("PUT", "/v1/passes/..%2Fetc", "{}", 404, "no such address"),
        ("PUT", "/v1/passes/.hidden", "{}", 422, "pass_id"),
        ("PUT", "/v1/passes/" + "x" * 65, "{}", 422, "pass_id"),
        ("POST", "/v1/passes/p1/finish", '{"axles": -1}', 422, "axles"),
        ("GET", "/v1/passes/p9", "", 404, "pass 'p9'"),
        ("GET", "/v1/jobs/j9", "", 404, "job 'j9'"),
        ("GET", "/v1/jobs/j9/events", "", 404, "job 'j9'"),
        ("GET", "/v1/calibrations/c9", "", 404, "calibration 'c9'"),
        ("GET", "/v1/measurements?limit=0", "", 422, "limit"),
        ("GET", "/v1/measurements?after=99999999999999999999", "", 422, "after"),
        ("GET", "/nowhere", "", 404, "/nowhere"),
        ("POST", "/v1/station", "", 405, "not by POST"),
    ],
)
def test_a_bad_call_is_answered_by_a_problem_that_names_it(
    call, method, path, content, status, says
):
    reply = call.request(
        method, path, content=content, headers={"Content-Type": "application/json"}
    )
    assert reply.status_code == status
    assert reply.headers["content-type"] == "application/problem+json"
    problem = reply.json()
    assert problem["status"] == status
    assert says in problem["detail"]
    assert {"type", "title", "instance"} <= problem.keys()


def test_an_error_nobody_foresaw_is_answered_without_detail(served, call, monkeypatch):
    def explode():
        raise RuntimeError("secret of the inside")

    monkeypatch.setattr(served.captures["left"], "status", explode)
    reply = call.get("/v1/station")
    assert reply.status_code == 500
    assert reply.json()["title"] == "Internal error"
    assert "secret" not in reply.text
    assert reply.headers["content-type"] == "application/problem+json"


def test_answers_carry_cautious_headers_and_an_id(call):
    headers = call.get("/v1/station").headers
    assert headers["X-Content-Type-Options"] == "nosniff"
    assert headers["Cache-Control"] == "no-store"
    assert len(headers["X-Request-Id"]) == 12


def test_the_station_tells_of_its_sensors(served, call):
    served.captures["right"].broken = "127.0.0.3: no camera answers"
    body = call.get("/v1/station").json()
    left, right = body["sensors"]
    assert (left["id"], left["state"], left["problem"]) == ("left", "idle", None)
    assert (right["state"], right["problem"]) == ("unreachable", "127.0.0.3: no camera answers")
    assert body["disk_free_bytes"] > 0
    assert body["software"].startswith("treadline ")


def test_metrics_count_requests_by_route_and_never_by_address(served, call):
    for name in ("p1", "p2", "p3"):
        call.get(f"/v1/passes/{name}")
    call.get("/nowhere/at/all")
    call.put("/v1/passes/p1", json={})
    text = call.get("/metrics").text
    count = 'station_http_requests_total{method="GET",route="/v1/passes/{pass_id}",status="404"}'
    assert f"{count} 3.0" in text
    assert "nowhere" not in text
    assert 'station_passes{state="recording"} 1.0' in text


def test_the_docs_page_lists_every_operation_and_loads_nothing(served, call):
    page = call.get("/docs").text
    for method, path in operations(served.app):
        assert method in page
        assert path in page
    assert "http://" not in page
    assert "https://" not in page
    assert "<script" not in page


def references(node):
    if isinstance(node, dict):
        yield from (value for key, value in node.items() if key == "$ref")
        node = list(node.values())
    if isinstance(node, list):
        for each in node:
            yield from references(each)


def test_the_contract_describes_every_operation_and_its_problems(served, call):
    schema = call.get("/openapi.json").json()
    assert schema == contract_of(served.app)
    known = {f"#/components/schemas/{name}" for name in schema["components"]["schemas"]}
    assert set(references(schema)) <= known
    for methods in schema["paths"].values():
        for operation in methods.values():
            assert "application/problem+json" in operation["responses"]["default"]["content"]
            assert operation["description"]


def test_following_a_job_tells_every_change_and_ends_with_it(served, call):
    now = served.station.now
    with served.store.change() as session:
        start(add_job(session, "j1", JobKind.CALIBRATE, "c1", at=now()), at=now())
    told = []

    def work():
        for fraction in (0.3, 0.6):
            if not seen[fraction].wait(5.0):
                return
            with served.store.change() as session:
                report_progress(session, "j1", fraction, "solving")
        seen["end"].wait(5.0)
        with served.store.change() as session:
            end(the(session, Job, "j1"), JobState.DONE, at=now())

    seen = {key: threading.Event() for key in (0.3, 0.6, "end")}
    after = {0.0: 0.3, 0.3: 0.6, 0.6: "end"}
    worker = threading.Thread(target=work)
    worker.start()
    with call.stream("GET", "/v1/jobs/j1/events") as stream:
        assert stream.headers["content-type"].startswith("text/event-stream")
        for line in stream.iter_lines():
            if line.startswith("data: "):
                job = json.loads(line.removeprefix("data: "))
                told.append((job["state"], job["progress"]))
                if job["progress"] in after:
                    seen[after[job["progress"]]].set()
    worker.join()
    assert told == [("running", 0.0), ("running", 0.3), ("running", 0.6), ("done", 1.0)]
