"""Shows what the station says of itself: readiness to everybody, alarms to those with a key.

What each trouble is made of is shown with the lookout; here, how they come out.
"""

import threading
import time

import pytest

from station.watching import TroubleKind

PATIENCE_S = 20.0
NOT_THERE = "no camera answers at 127.0.0.3"


def until(ask, reached):
    """Ask until the answer is as wanted: a look at the station is good for a second."""
    deadline = time.monotonic() + PATIENCE_S
    while not reached(answer := ask()):
        assert time.monotonic() < deadline, answer.text
        time.sleep(0.05)
    return answer


def unready(client):
    return until(lambda: client.get("/readyz"), lambda answer: answer.status_code == 503)


def test_every_part_is_told_and_one_without_a_calibration_is_ready_but_degraded(served):
    with served.client(key=None) as client:
        body = client.get("/readyz").json()
    assert body["ready"]
    parts = ["store", "worker", "sensor left", "sensor right", "disk", "clock", "controller"]
    assert list(body["parts"]) == list(body["details"]) == parts
    assert set(body["parts"].values()) == {"ready"}
    left = body["details"]["sensor left"]
    assert (left["condition"], left["reason"]) == ("degraded", "calibration_missing")
    assert left["since"] is not None
    assert body["details"]["worker"] == {"condition": "ready", "reason": None, "since": None}


def test_a_part_that_is_not_ready_says_why_without_telling_strangers_of_the_inside(served):
    served.worker_ready = False
    served.captures["right"].broken = NOT_THERE
    with served.client(key=None) as client:
        answer = unready(client)
    assert int(answer.headers["Retry-After"]) > 0
    body = answer.json()
    assert body["parts"]["worker"] == "not running"
    assert body["parts"]["sensor right"] == "its capture process does not answer"
    assert body["details"]["sensor right"]["reason"] == "capture_silent"
    assert body["parts"]["sensor left"] == "ready"
    for inside in ("127.0.0.3", str(served.layout.root), ".sock", "sqlite"):
        assert inside not in answer.text


def test_what_strangers_do_not_see_is_an_alarm_to_those_with_a_key(served, call):
    served.captures["right"].broken = NOT_THERE
    unready(call)
    (lost, *others) = call.get("/v1/station").json()["alarms"]
    assert (lost["kind"], lost["severity"], lost["part"]) == (
        "capture_silent",
        "critical",
        "sensor right",
    )
    assert lost["what"] == NOT_THERE
    assert "started again" in lost["cure"]
    assert {each["severity"] for each in others} == {"warning"}


def test_an_alarm_keeps_its_moment_and_goes_when_its_cause_has_gone(served, call):
    served.captures["right"].broken = NOT_THERE
    first = unready(call).json()["details"]["sensor right"]["since"]
    time.sleep(0.3)  # longer than an unready look is good
    assert call.get("/readyz").json()["details"]["sensor right"]["since"] == first
    served.captures["right"].broken = None
    until(lambda: call.get("/readyz"), lambda answer: answer.status_code == 200)
    kinds = {each["kind"] for each in call.get("/v1/station").json()["alarms"]}
    assert "capture_silent" not in kinds


def test_a_capture_that_hangs_holds_up_neither_readiness_nor_metrics(served, call, monkeypatch):
    let_go = threading.Event()
    monkeypatch.setattr(served.captures["left"], "status", lambda: let_go.wait(60.0))
    try:
        body = unready(call).json()
        assert body["details"]["sensor left"]["reason"] == "capture_silent"
        assert body["parts"]["sensor right"] == "ready"
        text = call.get("/metrics").text
        assert 'station_sensor_up{sensor="left"} 0.0' in text
        assert 'station_sensor_up{sensor="right"} 1.0' in text
    finally:
        let_go.set()


@pytest.mark.parametrize("served", [{"storage": {"keep_free_gb": 1e9}}], indirect=True)
def test_without_space_for_a_pass_the_station_is_not_ready(served, call):
    body = unready(call).json()
    assert body["parts"]["disk"] == "too little space for a pass"
    assert body["details"]["disk"]["reason"] == TroubleKind.DISK_SHORT


def test_a_store_that_does_not_answer_is_the_first_alarm(served, call, monkeypatch):
    def explode(*_):
        raise OSError("disk I/O error at /secret/path")

    monkeypatch.setattr("station.watching.lookout.store_troubles", explode)
    body = unready(call).json()
    assert body["parts"]["store"] == "does not answer"
    assert "secret" not in str(body)
