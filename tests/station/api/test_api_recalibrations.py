"""Shows recalibrations over HTTP: ordering, reading, answering, the line of a sensor's
calibrations, alarms.  What they find is the worker's and shown there."""

import json

import pytest

from station.operations import bring_into_force
from station.store import (
    STATION,
    Calibration,
    CalibrationState,
    Job,
    JobState,
    Recalibration,
    RecalibrationState,
    activate,
    active,
    end,
    start,
    the,
)
from station.store.callers import Scope

WHERE = "/v1/recalibrations"


def add_calibration(served, name, sensor="left"):
    with served.store.change() as session:
        row = Calibration(
            id=name, state=CalibrationState.READY, sensor=sensor, target="dots:7x8:12",
            method="joint", recording_ids={"recordings": [], "laser_off": []},
            created_at=served.station.now(), job_id="j", passed=True,
            document=json.dumps({"sensor": sensor}),
        )  # fmt: skip
        session.add(row)
    return name


def bring(served, name):
    with served.store.change() as session:
        row, present = the(session, Calibration, name), active(session, "left")
        seen = None if present is None else present.version
        activate(session, row, sensor="left", seen=seen, by=STATION, at=served.station.now())


def order(call, **body):
    return call.post(WHERE, json={"sensor": "left", **body})


def found(served, row_id, state, *, outcome="drifted", alarm=True):
    """Do what the worker does when it has come to a decision."""
    calibration = add_calibration(served, row_id)
    with served.store.change() as session:
        row = the(session, Recalibration, row_id)
        present = active(session, "left")
        row.calibration_id = calibration
        row.present_id, row.present_version = present.calibration_id, present.version
        row.outcome, row.action, row.alarm = outcome, "ask", alarm
        row.reasons = {"reasons": ["the sheets differ by 0.15 mm"]}
        row.figures = {"sheet_rms_mm": 0.15, "sheet_largest_mm": 0.3}
        row.taken = {"recordings": ["session.s1.left"], "target": "dots:7x8:12", "piece": []}
        row.ended_at = served.station.now()
        row.version += 1
        if state is RecalibrationState.ACTIVATED:
            bring_into_force(session, served.settings, row, by=STATION, at=row.ended_at)
        row.state = state
        job = the(session, Job, row.job_id)
        start(job, at=row.ended_at)
        end(job, JobState.DONE, at=row.ended_at)


@pytest.fixture
def asking(served, call):
    """The id of a recalibration that asks."""
    bring(served, add_calibration(served, "first"))
    row_id = order(call).json()["id"]
    found(served, row_id, RecalibrationState.ASKING)
    return row_id


def test_order_is_a_job_and_the_worker_is_told(served, call):
    reply = order(call)
    assert reply.status_code == 202
    body = reply.json()
    assert (body["state"], body["sensor"], body["ordered_by"]) == ("waiting", "left", "environment")
    assert reply.headers["Location"] == f"/v1/jobs/{body['job']}"
    assert served.queue.submitted == [("recalibrate", body["job"])]
    assert call.get(reply.headers["Location"]).json()["kind"] == "recalibrate"
    assert call.get(f"{WHERE}/{body['id']}").json() == body


def test_second_order_while_one_runs_is_refused_and_names_it(call):
    first = order(call).json()
    reply = order(call)
    assert (reply.status_code, reply.json()["state"]) == (409, "waiting")
    assert first["id"] in reply.json()["detail"]


@pytest.mark.parametrize(
    ("body", "status", "says"),
    [
        ({"sensor": "middle"}, 422, "the station has left, right"),
        ({"sensor": "left", "sessions": ["none"]}, 404, "knows no such one"),
        ({"sensor": "left", "when": "now"}, 422, "when"),
        ({}, 422, "sensor"),
    ],
)
def test_order_that_cannot_be_followed_says_why_and_orders_nothing(call, body, status, says):
    reply = call.post(WHERE, json=body)
    assert (reply.status_code, says in reply.json()["detail"]) == (status, True)
    assert call.get("/v1/sensors/left/recalibrations").json()["recalibrations"] == []


def test_sessions_may_be_named(call):
    call.put("/v1/calibration-sessions/s1", json={"sensor": "left", "target": "dots:7x8:12"})
    assert order(call, sessions=["s1"]).status_code == 409
    call.post("/v1/calibration-sessions/s1/capture")
    call.post("/v1/calibration-sessions/s1/finish")
    assert order(call, sessions=["s1"]).json()["recordings"] == ["session.s1.left"]


def test_question_shows_in_the_station_and_its_metrics_until_it_is_answered(served, call, asking):
    (left, _) = call.get("/v1/station").json()["sensors"]
    assert (left["asks"], left["alarm"]) == (asking, "the sheets differ by 0.15 mm")
    metrics = call.get("/metrics").text
    assert 'station_recalibration_alarm{sensor="left"} 1.0' in metrics
    assert 'station_recalibration_asking{sensor="left"} 1.0' in metrics
    assert 'station_recalibration_largest_meters{sensor="left"} 0.0003' in metrics
    assert 'station_calibration_age_seconds{sensor="left"}' in metrics
    answer(call, asking, "activate")
    (left, _) = call.get("/v1/station").json()["sensors"]
    assert (left["asks"], left["alarm"], left["active_calibration"]) == (None, None, asking)
    assert 'station_recalibration_alarm{sensor="left"} 0.0' in call.get("/metrics").text


def answer(call, row_id, action, *, etag=None):
    tag = etag or call.get(f"{WHERE}/{row_id}").headers["ETag"]
    body = {"action": action, "reason": "bracket was hit"}
    return call.post(f"{WHERE}/{row_id}/decision", json=body, headers={"If-Match": tag})


def test_person_who_agrees_brings_it_into_force_with_the_reason(call, asking):
    reply = answer(call, asking, "activate")
    body = reply.json()
    assert (reply.status_code, body["state"], body["activated_version"]) == (200, "activated", 2)
    assert (body["answered_by"], body["answer"]) == ("environment", "bracket was hit")
    assert call.get("/v1/sensors/left/active-calibration").json()["calibration"] == asking
    again = answer(call, asking, "activate")
    assert (again.status_code, again.json()) == (200, body)
    other = answer(call, asking, "refuse")
    assert (other.status_code, other.json()["state"]) == (409, "activated")


def test_person_who_refuses_leaves_everything_as_it_is(call, asking):
    assert answer(call, asking, "refuse").json()["state"] == "refused"
    (left, _) = call.get("/v1/station").json()["sensors"]
    assert (left["asks"], left["alarm"]) == (None, None)
    assert call.get("/v1/sensors/left/active-calibration").json()["calibration"] == "first"


def test_answer_needs_the_version_that_was_read(call, asking):
    body = {"action": "refuse", "reason": "why"}
    assert call.post(f"{WHERE}/{asking}/decision", json=body).status_code == 428
    assert answer(call, asking, "refuse", etag='"1"').status_code == 412
    assert call.get(f"{WHERE}/{asking}").json()["state"] == "asking"


def test_answer_after_another_calibration_came_into_force_is_refused(served, call, asking):
    bring(served, add_calibration(served, "other"))
    reply = answer(call, asking, "activate")
    assert reply.status_code == 409
    assert "recalibrate again" in reply.json()["detail"]
    assert call.get("/v1/sensors/left/active-calibration").json()["calibration"] == "other"


def test_answer_without_a_reason_is_refused(call, asking):
    body = {"action": "refuse", "reason": "  "}
    headers = {"If-Match": '"2"'}
    assert call.post(f"{WHERE}/{asking}/decision", json=body, headers=headers).status_code == 422


def test_line_of_calibrations_says_what_brought_each(served, call, asking):
    answer(call, asking, "activate")
    second = order(call).json()["id"]
    found(served, second, RecalibrationState.ACTIVATED, outcome="improved", alarm=False)
    first_page = call.get("/v1/sensors/left/calibrations", params={"limit": 2}).json()
    newest, chosen = first_page["calibrations"]
    assert (newest["version"], newest["outcome"]) == (3, "improved")
    assert newest["recalibration"] == second
    assert newest["figures"]["sheet_rms_mm"] == 0.15
    assert chosen["reasons"] == ["the sheets differ by 0.15 mm", "bracket was hit"]
    (oldest,) = call.get(
        "/v1/sensors/left/calibrations", params={"before": first_page["next"]}
    ).json()["calibrations"]
    assert (oldest["version"], oldest["calibration"], oldest["reasons"]) == (1, "first", [])
    assert oldest["recalibration"] is None


def test_recalibrations_are_listed_page_by_page(served, call, asking):
    second = order(call).json()["id"]
    where = "/v1/sensors/left/recalibrations"
    page = call.get(where, params={"limit": 1}).json()
    assert [each["id"] for each in page["recalibrations"]] == [second]
    rest = call.get(where, params={"limit": 1, "before": page["next"]}).json()
    assert ([each["id"] for each in rest["recalibrations"]], rest["next"]) == ([asking], None)
    for before in ("yesterday", "2026-01-01 x", ""):
        assert call.get(where, params={"before": before}).status_code == 422


def test_cancelled_order_has_failed_and_the_next_may_come(call):
    body = order(call).json()
    assert call.delete(f"/v1/jobs/{body['job']}").json()["state"] == "cancelled"
    assert call.get(f"{WHERE}/{body['id']}").json()["state"] == "failed"
    assert order(call).status_code == 202


@pytest.mark.parametrize(
    "path",
    [f"{WHERE}/none", "/v1/sensors/middle/calibrations", "/v1/sensors/middle/recalibrations"],
)
def test_what_is_not_known_is_404(call, path):
    assert call.get(path).status_code == 404


def test_only_who_may_calibrate_orders_and_answers(served, asking):
    with served.client(served.key(Scope.READ, Scope.OPERATE)) as client:
        assert order(client).status_code == 403
        assert answer(client, asking, "refuse").status_code == 403
        assert client.get(f"{WHERE}/{asking}").status_code == 200
