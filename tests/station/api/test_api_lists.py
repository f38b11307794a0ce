"""Shows that every list comes newest first, page by page, whole and once each, as filtered; what a
page may not be asked for is refused."""

from datetime import UTC, datetime, timedelta

import pytest
from served_station import Served

from station.store import (
    AxleWheel,
    Calibration,
    CalibrationSession,
    CalibrationState,
    Job,
    JobState,
    Pass,
    PassState,
    Recording,
    RigActivation,
    RigCalibration,
    SessionState,
)

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)
ROWS = 7
SENSORS_OF_RIG = (
    {"id": "inner", "address": "127.0.0.4"},
    {"id": "outer", "address": "127.0.0.5"},
)
RIG = {"id": "wheel", "sensors": ["inner", "outer"], "anchor": "outer"}
SENSORS = ("left", "right")


@pytest.fixture(scope="module")
def filled(tmp_path_factory, empty_store):
    """A station with seven of each kind; the last three of one moment, told apart by their ids."""
    served = Served(tmp_path_factory.mktemp("filled"), empty_store)
    fill(served)
    yield served
    served.close()


@pytest.fixture(scope="module")
def call(filled):
    with filled.client() as client:
        yield client


def fill(served):
    with served.store.change() as session:
        for number in range(ROWS):
            session.add_all([a_pass(number), a_session(number), a_job(number)])
            session.add_all([a_calibration(number), a_rig_calibration(number)])
        session.flush()
        session.add_all(a_recording(number) for number in range(ROWS))
        session.flush()
        session.add_all(a_wheel(number) for number in (1, 4))


def moment(number):
    return NOON + timedelta(minutes=min(number, 4))


def a_pass(number):
    return Pass(
        id=f"p{number}", state=PassState.DONE, train=f"t{number % 2}", opened_at=moment(number)
    )


def a_session(number):
    return CalibrationSession(
        id=f"s{number}",
        state=SessionState.RECORDED,
        sensor=SENSORS[number % 2],
        target="dots:7x8:12",
        pictures=3,
        opened_at=moment(number),
    )


def a_job(number):
    return Job(
        id=f"j{number}",
        kind="measure",
        subject=f"p{number}",
        state=JobState.DONE if number % 2 else JobState.FAILED,
        progress=1.0,
        doing="done",
        created_at=moment(number),
    )


def a_calibration(number):
    return Calibration(
        id=f"c{number}",
        state=CalibrationState.READY,
        sensor=SENSORS[number % 2],
        target="dots:7x8:12",
        method="joint",
        recording_ids={"recordings": [], "laser_off": []},
        created_at=moment(number),
        job_id="j",
        document="{}",
    )


def a_rig_calibration(number):
    return RigCalibration(
        id=f"g{number}",
        state=CalibrationState.READY,
        rig=("wheel", "other")[number % 2],
        created_at=moment(number),
    )


def a_recording(number):
    """The first four are of passes, the others of sessions."""
    of = {"pass_id": f"p{number}"} if number < 4 else {"session_id": f"s{number}"}
    return Recording(
        id=f"r{number}",
        sensor=SENSORS[number % 2],
        path="x",
        opened_at=moment(number),
        recovered=False,
        **of,
    )


def a_wheel(number):
    return AxleWheel(
        pass_id=f"p{number}",
        place=1,
        side="left",
        placing="certain",
        others={"measurements": []},
        wheelset="ws-1",
        jumps={},
    )


def names(call, path, key, **query):
    """Return the ids of a list, taken two by two."""
    found, before = [], None
    while True:
        asked = query | {"limit": 2} | ({} if before is None else {"before": before})
        page = call.get(path, params=asked).raise_for_status().json()
        assert set(page) == {key, "next"}
        assert len(page[key]) <= 2
        found += [each["id"] for each in page[key]]
        before = page["next"]
        if before is None:
            return found


@pytest.mark.parametrize("served", [{"sensors": SENSORS_OF_RIG, "rigs": [RIG]}], indirect=True)
def test_the_calibrations_that_came_into_force_on_a_rig_are_listed_the_last_one_first(served):
    fill(served)
    with served.store.change() as session:
        for version in (1, 2, 3):
            session.add(
                RigActivation(
                    rig="wheel",
                    version=version,
                    rig_calibration_id=f"g{2 * version - 2}",
                    activated_at=NOON,
                    activated_by="test",
                )
            )
    place = "/v1/rigs/wheel/calibrations"
    with served.client() as call:
        first = call.get(place, params={"limit": 2}).json()
        rest = call.get(place, params={"limit": 2, "before": first["next"]}).json()
        assert call.get("/v1/rigs/none/calibrations").status_code == 404
    found = [each["calibration"] for each in first["calibrations"] + rest["calibrations"]]
    assert found == ["g4", "g2", "g0"]
    assert rest["next"] is None


def at(minutes):
    return (NOON + timedelta(minutes=minutes)).isoformat()


@pytest.mark.parametrize(
    ("path", "key", "letter"),
    [
        ("/v1/passes", "passes", "p"),
        ("/v1/jobs", "jobs", "j"),
        ("/v1/recordings", "recordings", "r"),
        ("/v1/calibrations", "calibrations", "c"),
        ("/v1/rig-calibrations", "calibrations", "g"),
        ("/v1/calibration-sessions", "sessions", "s"),
    ],
)
def test_a_list_is_whole_and_newest_first_whatever_its_pages(call, path, key, letter):
    assert names(call, path, key) == [f"{letter}{number}" for number in reversed(range(ROWS))]


@pytest.mark.parametrize(
    ("path", "key", "query", "expected"),
    [
        ("/v1/passes", "passes", {"train": "t1"}, "p5 p3 p1"),
        ("/v1/passes", "passes", {"state": "failed"}, ""),
        ("/v1/passes", "passes", {"wheelset": "ws-1"}, "p4 p1"),
        ("/v1/passes", "passes", {"from": at(1), "to": at(3)}, "p2 p1"),
        ("/v1/jobs", "jobs", {"state": "failed"}, "j6 j4 j2 j0"),
        ("/v1/jobs", "jobs", {"kind": "compact"}, ""),
        ("/v1/jobs", "jobs", {"subject": "p3"}, "j3"),
        ("/v1/recordings", "recordings", {"sensor": "right"}, "r5 r3 r1"),
        ("/v1/recordings", "recordings", {"pass": "p2"}, "r2"),
        ("/v1/recordings", "recordings", {"session": "s5"}, "r5"),
        ("/v1/recordings", "recordings", {"from": at(4)}, "r6 r5 r4"),
        ("/v1/recordings", "recordings", {"to": at(1)}, "r0"),
        ("/v1/calibrations", "calibrations", {"sensor": "left"}, "c6 c4 c2 c0"),
        ("/v1/rig-calibrations", "calibrations", {"rig": "other"}, "g5 g3 g1"),
        ("/v1/calibration-sessions", "sessions", {"sensor": "right"}, "s5"),
    ],
)
def test_a_filter_leaves_what_it_names(call, path, key, query, expected):
    assert names(call, path, key, **query) == expected.split()


def test_rows_of_lists_are_those_that_are_fetched_by_themselves(call):
    for path, key, name in (
        ("/v1/passes", "passes", "p1"),
        ("/v1/jobs", "jobs", "j1"),
        ("/v1/calibration-sessions", "sessions", "s5"),
    ):
        rows = call.get(path).json()[key]
        (row,) = [each for each in rows if each["id"] == name]
        assert row == call.get(f"{path}/{name}").raise_for_status().json()


def test_what_comes_while_a_list_is_read_moves_no_row_of_it(served):
    fill(served)
    with served.client() as call:
        page = call.get("/v1/passes", params={"limit": 3}).json()
        with served.store.change() as session:
            late = NOON + timedelta(hours=1)
            session.add(Pass(id="late", state=PassState.DONE, opened_at=late))
        rest = names(call, "/v1/passes", "passes", before=page["next"])
    assert [each["id"] for each in page["passes"]] + rest == [
        f"p{number}" for number in reversed(range(ROWS))
    ]


@pytest.mark.parametrize(
    ("query", "says"),
    [
        ({"before": "yesterday"}, "`next` of a page"),
        ({"before": "2026-07-01T12:00:00 p1"}, "`next` of a page"),
        ({"before": "0001-01-01T00:00:00+14:00 p1"}, "`next` of a page"),
        ({"before": "2026-07-01T12:00:00+00:00 ../p1"}, "`next` of a page"),
        ({"from": "2026-07-01T12:00:00"}, "timezone"),
        ({"from": "1782907200"}, "no moment"),
        ({"from": "0001-01-01T00:00:00+14:00"}, "the year 1"),
        ({"from": at(3), "to": at(1)}, "comes later"),
        ({"limit": "0"}, "limit"),
        ({"limit": "1001"}, "limit"),
    ],
)
def test_what_no_page_can_be_found_by_is_refused(call, query, says):
    reply = call.get("/v1/passes", params=query)
    assert reply.status_code == 422
    assert says in reply.json()["detail"]
