"""Shows that each change that came over the network is in the audit trail, and who may read it."""

import pytest

from station.store.callers import Scope


def trail(call, **query):
    return call.get("/v1/audit", params=query).raise_for_status().json()["entries"]


def test_a_pass_leaves_who_armed_and_who_finished_it_and_from_where(call):
    call.put("/v1/passes/p1", json={"train": "IC 1"}).raise_for_status()
    call.put("/v1/passes/p1", json={"train": "IC 1"}).raise_for_status()
    call.post("/v1/passes/p1/finish", json={"axles": 4}).raise_for_status()
    finish, arm = trail(call, subject="p1")
    assert (arm["action"], arm["who"], arm["address"]) == ("arm", "environment", "127.0.0.1")
    assert (finish["action"], finish["kind"], finish["after"]) == ("finish", "pass", {"axles": 4})


def test_a_calibration_session_leaves_who_opened_and_who_closed_it(call):
    put = call.put("/v1/calibration-sessions/s1", json={"sensor": "left", "target": "dots:7x8:12"})
    put.raise_for_status()
    call.post("/v1/calibration-sessions/s1/finish").raise_for_status()
    order = {"sensor": "left", "session": "s1"}
    calibration = call.post("/v1/calibrations", json=order).raise_for_status().json()
    call.delete(f"/v1/jobs/{calibration['job']}").raise_for_status()
    found = [(entry["action"], entry["kind"], entry["subject"]) for entry in trail(call)]
    assert found == [
        ("cancel", "job", calibration["job"]),
        ("order", "calibration", calibration["id"]),
        ("finish", "calibration session", "s1"),
        ("arm", "calibration session", "s1"),
    ]


def test_a_refused_change_leaves_nothing(call):
    assert call.post("/v1/passes/unknown/finish", json={}).status_code == 404
    assert trail(call) == []


@pytest.mark.parametrize("scope", [Scope.READ, Scope.OPERATE, Scope.CALIBRATE])
def test_only_an_administrator_reads_the_trail(served, scope):
    with served.client(served.key(scope)) as client:
        assert client.get("/v1/audit").status_code == 403


def test_the_trail_is_read_page_by_page(call):
    for n in range(3):
        call.put(f"/v1/passes/p{n}", json={}).raise_for_status()
        call.post(f"/v1/passes/p{n}/finish", json={"axles": 0}).raise_for_status()
    first = call.get("/v1/audit", params={"limit": 4}).json()
    rest = call.get("/v1/audit", params={"limit": 4, "before": first["next"]}).json()
    assert [entry["subject"] for entry in first["entries"]] == ["p2", "p2", "p1", "p1"]
    assert [entry["subject"] for entry in rest["entries"]] == ["p0", "p0"]
    assert rest["next"] is None
