"""Shows a station that is told to end, or loses its database, in the middle of a pass: real
processes, a camera that sees wheels, a controller that says everything again until it is
answered."""

from concurrent.futures import ThreadPoolExecutor
from threading import Event

import httpx
import pytest
from postgres_server import PostgresServer, initdb

from station.bench.service.blind_controller import BlindController
from station.bench.service.kill_trials import roll_by, stage_in
from station.bench.service.pass_truth import left_over, truth_of_pass
from station.bench.service.small_sensor import SENSOR
from station.bench.service.station_process import Victim

PATIENCE_S = 60.0
PARTS = (Victim.SUPERVISOR, Victim.API, Victim.CAPTURE, Victim.RECORDER, Victim.WORKER)


@pytest.fixture(scope="module")
def stage(tmp_path_factory):
    with stage_in(tmp_path_factory.mktemp("interrupted")) as stage:
        yield stage


def assert_sound(stage, pass_id, triggers, lost):
    truth = truth_of_pass(stage.store, stage.station.layout, pass_id, triggers)
    assert truth.lost in lost
    assert truth.unsaid == truth.unsound == 0, truth
    assert truth.missing == truth.doubled == truth.differing == 0, truth


@pytest.mark.slow  # the shorter one beside the tests of `station serve` looks at the files alone
@pytest.mark.parametrize(
    ("pass_id", "all_at_once"), [("to-the-supervisor", False), ("to-all", True)]
)
def test_a_station_told_to_end_in_the_middle_of_a_train_keeps_what_it_saw(
    stage, pass_id, all_at_once
):
    gone = Event()
    station = stage.station
    with station.client() as client, ThreadPoolExecutor(1) as beside:
        controller = BlindController(client, SENSOR, PATIENCE_S)
        client.arm_pass(pass_id)
        taken = beside.submit(controller.take_pass, pass_id, axles=4, gone=gone)
        roll_by(stage.camera, 3)
        # A person may press Ctrl-C twice, and a service manager tells everybody.
        station.ask_to_end(all_at_once=all_at_once)
        station.ask_to_end(all_at_once=all_at_once)
        assert station.wait_for_end() == 0
        # The standard library's own helper ends a moment after the last of those it looks after.
        station.wait(lambda: not station.processes(), "for all processes to end")
        assert station.folders_of_sockets() == []
        gone.set()
        station.start()
        assert taken.result()["state"] in {"done", "recovered"}
    # The fourth came while there was no station; the third may have been on its way to it.
    assert_sound(stage, pass_id, triggers=4, lost={1, 2})
    station.wait(lambda: not left_over(station, stage.store), "to be at rest")


@pytest.fixture(scope="module")
def database():
    program = initdb()
    if program is None:
        pytest.skip("no PostgreSQL on this host; deploy/test installs it")
    server = PostgresServer(program.parent)
    yield server
    server.stop()


@pytest.fixture(scope="module")
def stage_on(database, tmp_path_factory):
    folder = tmp_path_factory.mktemp("database")
    with stage_in(folder, database.empty_database()) as stage:
        yield stage


def test_a_database_that_crashes_in_the_middle_of_a_train_costs_time_and_no_frame(
    stage_on, database
):
    stage, station, gone = stage_on, stage_on.station, Event()
    before = {part: station.pid_of(part) for part in PARTS}
    ask = httpx.Client(
        base_url=station.url,
        headers={"Authorization": f"Bearer {station.key}"},
        timeout=PATIENCE_S,
        trust_env=False,
    )
    with station.client() as client, ThreadPoolExecutor(1) as beside, ask:
        client.arm_pass("p1")
        controller = BlindController(client, SENSOR, PATIENCE_S)
        roll_by(stage.camera, 2)
        database.crash()
        roll_by(stage.camera, 2)

        refused = ask.get("/v1/passes/p1")
        assert refused.status_code == 503
        assert refused.headers["content-type"] == "application/problem+json"
        assert int(refused.headers["Retry-After"]) > 0
        station.wait(lambda: "store" in said(ask), "for readiness to name the store")
        assert ask.get("/healthz").status_code == 200

        gone.set()
        taken = beside.submit(controller.take_pass, "p1", axles=4, gone=gone)
        database.start()
        assert taken.result()["state"] == "done"
        station.wait_until_ready()
    assert controller.server_errors == 0
    assert {part: station.pid_of(part) for part in PARTS} == before
    assert_sound(stage, "p1", triggers=4, lost={0})


def said(ask):
    """Return the parts that are not ready."""
    parts = ask.get("/readyz").json()["parts"]
    return {part for part, state in parts.items() if state != "ready"}
