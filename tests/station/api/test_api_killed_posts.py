"""Shows that a POST with an Idempotency-Key leaves the same behind, however often and wherever the
API process was killed while it was done: every POST of the contract, after each thing it does that
lasts.  An upload needs no key: it is known again by its bytes, see `test_api_uploads`."""

import contextlib
import json
from collections import Counter

import pytest
from mortal import Died
from rig_recordings import true_rig
from sqlalchemy import func, select
from trackside import InProcess

from station.api import contract
from station.api.bodies import STREAMED
from station.store import (
    STATION,
    AuditEntry,
    Calibration,
    CalibrationSession,
    CalibrationState,
    Recalibration,
    RecalibrationState,
    Recording,
    RigCalibration,
    SessionState,
    Table,
    activate,
    active,
)

SENSORS = (
    {"id": "inner", "address": "127.0.0.2"},
    {"id": "outer", "address": "127.0.0.3"},
)
RIGS = ({"id": "wheel", "sensors": ["inner", "outer"]},)
MOST_DEEDS = 30


class Ground:
    """A station with all that orders need, and what there is of each thing."""

    def __init__(self, served):
        self.served = served
        for sensor in ("inner", "outer"):
            self.add_calibration(f"of-{sensor}", sensor, in_force=True)
            self.add_session(f"of-{sensor}", sensor)

    def put(self, path, body):
        assert self.served.request("PUT", path, json=body).status_code == 201

    def open_session(self, name):
        body = {"rig": "wheel", "target": "dots:7x8:12"}
        self.put(f"/v1/calibration-sessions/{name}", body)

    def add_calibration(self, name, sensor, *, in_force=False):
        now = self.served.station.now()
        with self.served.store.change() as session:
            row = Calibration(
                id=name, state=CalibrationState.READY, sensor=sensor, target="dots:7x8:12",
                method="joint", recording_ids={"recordings": [], "laser_off": []},
                created_at=now, job_id="j", document="{}",
            )  # fmt: skip
            session.add(row)
            session.flush()
            if in_force:
                activate(session, row, sensor=sensor, seen=None, by=STATION, at=now)

    def add_rig_calibration(self, name):
        with self.served.store.change() as session:
            session.add(
                RigCalibration(
                    id=name, state=CalibrationState.READY, rig="wheel",
                    created_at=self.served.station.now(), document=true_rig().model_dump_json(),
                )
            )  # fmt: skip

    def add_session(self, name, sensor):
        now = self.served.station.now()
        with self.served.store.change() as session:
            session.add(
                CalibrationSession(
                    id=name, state=SessionState.RECORDED, sensor=sensor, target="dots:7x8:12",
                    pictures=3, opened_at=now,
                )
            )  # fmt: skip
            session.flush()
            session.add(
                Recording(
                    id=f"recording-of-{sensor}", sensor=sensor, session_id=name,
                    path=f"{name}.mcap", opened_at=now, closed_at=now, recorded=3, recovered=False,
                )
            )  # fmt: skip

    def add_asking(self, name):
        """Add a recalibration that asks a person."""
        self.add_calibration(f"new-{name}", "inner")
        with self.served.store.change() as session:
            session.add(
                Recalibration(
                    id=name, state=RecalibrationState.ASKING, sensor="inner", job_id="j",
                    ordered_at=self.served.station.now(), ordered_by="x", findings={}, version=3,
                    calibration_id=f"new-{name}", outcome="drifted",
                    present_version=active(session, "inner").version,
                )
            )  # fmt: skip

    def tidy(self):
        """End what would stand in the way of the next call."""
        with self.served.store.change() as session:
            for row in session.query(Recalibration).where(
                Recalibration.state == RecalibrationState.WAITING
            ):
                row.state = RecalibrationState.FAILED
            sessions = select(CalibrationSession.id).where(
                CalibrationSession.state == SessionState.OPEN
            )
            names = list(session.scalars(sessions))
        for name in names:
            self.served.request("POST", f"/v1/calibration-sessions/{name}/finish")

    def traces(self):
        """How many rows of each table and entries of the audit trail there are, and frames."""
        with self.served.store.look() as session:
            found = Counter({
                table.name: session.scalar(select(func.count()).select_from(table))
                for table in Table.metadata.sorted_tables
                if table.name != "table_revisions"  # counts writes, which are not what is left
            })
            found.update(f"{row.action} {row.kind}" for row in session.query(AuditEntry))
            found["pictures"] = sum(row.pictures for row in session.query(CalibrationSession))
        files = (self.served.layout.root / "recordings").rglob("*.mcap*")
        found["frames"] = sum(len(file.read_text().splitlines()) for file in files)
        return found


def finish_pass(ground, name):
    ground.put(f"/v1/passes/{name}", {})
    for capture in ground.served.captures.values():
        capture.wheel()
    return f"/v1/passes/{name}/finish", {"axles": 1}, {}


def capture(ground, name):
    ground.open_session(name)
    return f"/v1/calibration-sessions/{name}/capture", None, {}


def finish_session(ground, name):
    ground.open_session(name)
    return f"/v1/calibration-sessions/{name}/finish", None, {}


def calibrate(_ground, _name):
    return "/v1/calibrations", {"sensor": "inner", "session": "of-inner"}, {}


def refuse(ground, name):
    ground.add_calibration(f"bad-{name}", "inner")
    return f"/v1/calibrations/bad-{name}/refusal", {"reason": "taken in fog"}, {}


def refuse_rig(ground, name):
    ground.add_rig_calibration(f"bad-{name}")
    return f"/v1/rig-calibrations/bad-{name}/refusal", {"reason": "taken in fog"}, {}


def calibrate_rig(_ground, _name):
    recordings = {sensor: f"recording-of-{sensor}" for sensor in ("inner", "outer")}
    body = {"rig": "wheel", "recordings": recordings, "target": "dots:7x8:12"}
    return "/v1/rig-calibrations", body, {}


def bring_rig(_ground, _name):
    return "/v1/rig-calibrations/files", json.loads(true_rig().model_dump_json()), {}


def recalibrate(_ground, _name):
    return "/v1/recalibrations", {"sensor": "inner"}, {}


def decide(ground, name):
    ground.add_asking(name)
    body = {"action": "activate", "reason": "it fits"}
    return f"/v1/recalibrations/{name}/decision", body, {"If-Match": '"3"'}


def replay(_ground, _name):
    body = {"recordings": ["recording-of-inner"], "calibrations": {"inner": "of-inner"}}
    return "/v1/replays", body, {}


POSTS = {
    "/v1/passes/{pass_id}/finish": finish_pass,
    "/v1/calibration-sessions/{session_id}/capture": capture,
    "/v1/calibration-sessions/{session_id}/finish": finish_session,
    "/v1/calibrations": calibrate,
    "/v1/calibrations/{calibration_id}/refusal": refuse,
    "/v1/rig-calibrations": calibrate_rig,
    "/v1/rig-calibrations/{calibration_id}/refusal": refuse_rig,
    "/v1/rig-calibrations/files": bring_rig,
    "/v1/recalibrations": recalibrate,
    "/v1/recalibrations/{recalibration_id}/decision": decide,
    "/v1/replays": replay,
}


def test_every_post_of_the_contract_is_killed_here():
    posts = {path for path, operations in contract()["paths"].items() if "post" in operations}
    streamed = {path for _, path in STREAMED}
    assert posts - streamed == set(POSTS), "give a new POST its entry in POSTS"


@pytest.fixture
def ground(tmp_path, empty_store):
    served = InProcess(tmp_path, empty_store, sensors=SENSORS, rigs=RIGS)
    yield Ground(served)
    served.close()


@pytest.mark.parametrize("path", POSTS)
def test_a_post_killed_anywhere_and_made_again_leaves_what_one_leaves(ground, path):
    expected, status, _ = made(ground, POSTS[path], "whole", deeds=None)
    assert expected.total() > 0
    for deeds in range(MOST_DEEDS):
        left, again, died = made(ground, POSTS[path], f"n{deeds}", deeds=deeds)
        assert (left, again) == (expected, status), f"killed after {deeds} deeds"
        if not died:
            break
    # The key is noted before and the answer kept after: what is done lies between.
    assert not died
    assert deeds >= 3


def made(ground, prepare, name, *, deeds):
    """Make a call, the API process being killed after so many deeds of it, and make it again.

    Returns what it left behind, the status of its answer, and whether the process was killed.
    """
    served = ground.served
    path, body, headers = prepare(ground, name)
    given = {"json": body, "headers": {"Idempotency-Key": f"key-{name}", **headers}}
    before = ground.traces()
    if deeds is not None:
        served.life.end_after(deeds)
    with contextlib.suppress(Died):
        served.request("POST", path, **given)
    died = served.life.dead
    served.kill_and_begin_again()
    answer = served.request("POST", path, **given)
    assert answer.status_code < 300, answer.text
    once_more = served.request("POST", path, **given)
    assert (once_more.status_code, once_more.text) == (answer.status_code, answer.text)
    left = ground.traces() - before
    ground.tidy()
    return left, answer.status_code, died
