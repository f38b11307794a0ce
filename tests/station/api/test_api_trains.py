"""Shows what a controller and a planner get of a train: axles, alarms, trends.  The store and the
steps of the worker are real; only what it reads out of recordings is a double."""

from datetime import UTC, datetime, timedelta

import pytest
from test_api_passes import put_calibration_in_force

from measure import Quantity
from station.documents import (
    CalibrationDocument,
    CameraDocument,
    MeasurementDocument,
    PlaneDocument,
    ReadingDocument,
    RmsDocument,
    WheelDocument,
)
from station.settings import LimitsSettings
from station.store import Calibration, Pass, the
from station.worker.context import Mathematics, WorkContext
from station.worker.measuring import begin_measuring, conclude_measuring, measure_step

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)
AXLES_S = (0.0, 0.5, 3.8, 4.3)
CONSIST = ["w1", "w2", "w3", "w4"]


def calibration_json(sensor):
    return CalibrationDocument(
        sensor=sensor,
        created=NOON,
        software="treadline 0",
        method="joint",
        camera=CameraDocument(fx=1, fy=1, cx=0, cy=0, width=8, height=8),
        plane=PlaneDocument(a=0, b=0, c=-1, d=500),
        plane_covariance=((0.0,) * 4,) * 4,
        rms=RmsDocument(dots_px=0.1, stripe_px=0.1),
        poses=(),
        quality={},
        options={},
        inputs=(),
    ).model_dump_json()


def wheel(sensor, frame, at_s, *, reason=None, u95=0.03, **values):
    readings = {
        name: ReadingDocument(value=value, u95=u95, status="ok", alarm="none")
        for name, value in values.items()
    }
    return WheelDocument(
        source=f"{sensor}.mcap",
        sensor=sensor,
        frame=frame,
        frames=(frame,),
        time=NOON + timedelta(seconds=at_s),
        reason=reason,
        **readings,
    )


def side_of_train(sensor, *, without=(), **values):
    """One wheel an axle; those of axles in `without` were not seen."""
    return [
        wheel(sensor, number, at_s, **values)
        for number, at_s in enumerate(AXLES_S, start=1)
        if number not in without
    ]


class Trackside:
    """A controller's calls, and the worker that answers them."""

    def __init__(self, served, call):
        self.served, self.call = served, call
        self.days = 0.0
        for sensor in ("left", "right"):
            put_calibration_in_force(served, sensor)
            with served.store.change() as session:
                row = the(session, Calibration, f"of-{sensor}")
                row.document = calibration_json(sensor)

    def roll(self, pass_id, left, right, *, axles=4, consist=None, **settings):
        body = {} if consist is None else {"consist": consist}
        assert self.call.put(f"/v1/passes/{pass_id}", json=body).status_code == 201
        finished = self.call.post(f"/v1/passes/{pass_id}/finish", json={"axles": axles}).json()
        with self.served.store.change() as session:
            the(session, Pass, pass_id).opened_at = NOON + timedelta(days=self.days)
        self.days += 1.0
        self._measure(finished["job"], {"left": left, "right": right}, settings)
        return self.call.get(f"/v1/passes/{pass_id}/wheels").json()

    def _measure(self, job, wheels, changed):
        def measure(_sources, calibration, *, reference, limits, progress, since=None):
            return MeasurementDocument(
                created=NOON,
                software="treadline 0",
                calibration=None,
                reference=reference,
                regime=limits.regime,
                wheels=tuple(wheels[calibration.sensor]),
            )

        settings = self.served.settings.model_copy(update=changed)
        context = WorkContext(
            settings, self.served.store, self.served.layout, Mathematics(None, measure, None, None)
        )
        steps = begin_measuring(context, job)
        results = [
            measure_step(context, job, each, place=place, of=len(steps))
            for place, each in enumerate(steps)
        ]
        conclude_measuring(context, job, results)


@pytest.fixture
def trackside(served, call):
    return Trackside(served, call)


def test_wheels_of_both_sides_are_axles_with_their_differences(trackside):
    body = trackside.roll(
        "p1",
        side_of_train("left", flange_height=28.5),
        side_of_train("right", flange_height=28.4, u95=0.04),
    )
    assert body["state"] == "done"
    assert [axle["number"] for axle in body["axles"]] == [1, 2, 3, 4]
    assert {axle["placing"] for axle in body["axles"]} == {"certain"}
    by_id = {row["id"]: row["wheel"] for row in body["wheels"]}
    for axle in body["axles"]:
        for side in ("left", "right"):
            shown = by_id[axle[side]["measurement"]]
            assert (shown["sensor"], shown["axle"], shown["side"]) == (side, axle["number"], side)
        found = axle["differences"]["flange_height"]
        assert found["value"] == pytest.approx(0.1)
        assert found["u95"] == pytest.approx(0.05)
        assert "tread_wear" not in axle["differences"]
    assert body["axles"][1]["passed_at"] == "2026-07-01T12:00:00.500000Z"
    assert body["vehicles"] == []


def test_a_wheel_that_was_missed_is_there_with_its_reason(trackside):
    dirty = wheel("right", 4, AXLES_S[3], reason="no flange tip is seen")
    body = trackside.roll(
        "p1", side_of_train("left"), [*side_of_train("right", without=(2, 4)), dirty]
    )
    axles = body["axles"]
    assert len(axles) == 4
    assert axles[1]["right"]["measurement"] is None
    assert axles[1]["right"]["reason"] == "sensor right: no frame of this axle"
    assert axles[3]["right"]["measurement"] is not None
    assert axles[3]["right"]["reason"] == "no flange tip is seen"


def test_an_axle_nobody_saw_is_a_row_at_the_trigger_it_missed(trackside):
    body = trackside.roll(
        "p1", side_of_train("left", without=(3,)), side_of_train("right", without=(3,))
    )
    assert [axle["number"] for axle in body["axles"]] == [1, 2, 3, 4]
    third = body["axles"][2]
    assert (third["left"]["measurement"], third["right"]["measurement"]) == (None, None)
    assert third["remark"] == "counted, but seen by no sensor"


def test_numbers_of_frames_that_nobody_triggered_place_no_axle(trackside):
    free = [
        sensor.model_copy(update={"trigger": "free"})
        for sensor in trackside.served.settings.sensors
    ]
    body = trackside.roll(
        "p1",
        side_of_train("left", without=(3,)),
        side_of_train("right", without=(3,)),
        sensors=tuple(free),
    )
    assert {axle["placing"] for axle in body["axles"]} == {"unplaced"}


def test_more_axles_counted_than_seen_are_rows_without_a_place(trackside):
    body = trackside.roll("p1", side_of_train("left"), side_of_train("right"), axles=5)
    assert [axle["number"] for axle in body["axles"]] == [None] * 5
    assert {axle["placing"] for axle in body["axles"]} == {"unplaced"}
    assert body["counted"] == 5


def test_a_pass_without_any_frame_still_has_its_axles(served, call):
    for capture in served.captures.values():
        capture.wheels = 0
    call.put("/v1/passes/p1", json={})
    call.post("/v1/passes/p1/finish", json={"axles": 3})
    body = call.get("/v1/passes/p1/wheels").json()
    assert (body["state"], body["wheels"]) == ("failed", [])
    assert [axle["number"] for axle in body["axles"]] == [1, 2, 3]
    assert body["axles"][0]["left"]["reason"] == "sensor left: no frame was recorded"


def test_frames_that_no_calibration_could_measure_are_told(call):
    call.put("/v1/passes/p1", json={})
    call.post("/v1/passes/p1/finish", json={"axles": 2})
    body = call.get("/v1/passes/p1/wheels").json()
    assert body["state"] == "recorded"
    assert body["axles"][1]["right"]["reason"] == "sensor right: no calibration was active"


def test_a_consist_is_named_once_and_the_same_call_again_is_the_same(call):
    named = {"train": "IC 5", "consist": ["w1", {"wheelset": "w2", "vehicle": "A"}]}
    first = call.put("/v1/passes/p1", json=named)
    again = call.put("/v1/passes/p1", json=named)
    assert (first.status_code, again.status_code) == (201, 200)
    assert first.json() == again.json()
    assert [each["wheelset"] for each in first.json()["consist"]] == ["w1", "w2"]
    for body in ({"train": "IC 5"}, {"train": "IC 5", "consist": ["w2", "w1"]}):
        assert call.put("/v1/passes/p1", json=body).status_code == 409
    other = call.post("/v1/passes/p1/finish", json={"axles": 2, "consist": ["w2", "w1"]})
    assert (other.status_code, other.json()["state"]) == (409, "recording")
    finished = call.post("/v1/passes/p1/finish", json={"axles": 2}).json()
    assert finished["axles"] == 2
    assert call.put("/v1/passes/p1", json=named).json() == finished


def test_a_consist_may_be_named_when_the_train_has_gone(call):
    call.put("/v1/passes/p1", json={})
    gone = {"axles": 2, "consist": ["w1", "w2"]}
    finished = call.post("/v1/passes/p1/finish", json=gone).json()
    assert [each["wheelset"] for each in finished["consist"]] == ["w1", "w2"]
    assert call.post("/v1/passes/p1/finish", json=gone).json() == finished
    other = call.post("/v1/passes/p1/finish", json={"axles": 2, "consist": ["w3", "w2"]})
    assert other.status_code == 409
    # A duplicate of the first call that comes late did not know the consist yet.
    assert call.put("/v1/passes/p1", json={}).json() == finished


@pytest.mark.parametrize(
    ("consist", "says"),
    [
        (["w1", "w1"], "names wheelset 'w1' twice"),
        ([], "at least 1 item"),
        (["a b"], "pattern"),
        ([{"wheelset": "w1", "orientation": "sideways"}], "orientation"),
    ],
)
def test_a_consist_without_sense_is_refused_and_arms_nothing(served, call, consist, says):
    reply = call.put("/v1/passes/p1", json={"consist": consist})
    assert reply.status_code == 422
    assert says in reply.json()["detail"]
    assert served.captures["left"].plans == []


def test_a_consist_of_another_length_identifies_no_wheel_and_says_so(trackside, call):
    body = trackside.roll(
        "p1", side_of_train("left"), side_of_train("right"), consist=[*CONSIST, "w5"]
    )
    assert [axle["wheelset"] for axle in body["axles"]] == [None] * 4
    assert body["remark"].startswith("the consist names 5 wheelsets but 4 axles were counted")
    assert call.get("/v1/wheelsets/w1/trend").status_code == 404


def test_vehicles_of_a_consist_are_compared_within(trackside):
    consist = [
        {"wheelset": name, "vehicle": vehicle}
        for name, vehicle in zip(CONSIST, "AABB", strict=True)
    ]
    left = [wheel("left", n, at, tread_wear=0.5 * n) for n, at in enumerate(AXLES_S, start=1)]
    body = trackside.roll("p1", left, side_of_train("right", tread_wear=1.0), consist=consist)
    spreads = {each["vehicle"]: each for each in body["vehicles"]}
    assert (spreads["A"]["greatest"], spreads["A"]["smallest"]) == ("axle 1 right", "axle 1 left")
    assert spreads["B"]["value"] == pytest.approx(1.0)


def test_wear_of_a_wheelset_is_followed_though_it_runs_turned_about(trackside, call):
    turned = [{"wheelset": name, "orientation": "reversed"} for name in CONSIST[::-1]]
    for day in range(4):
        left, right = (
            side_of_train(side, tread_wear=start + rate * day)
            for side, start, rate in (("left", 1.0, 0.05), ("right", 2.0, 0.02))
        )
        if day == 2:  # it comes back: last axle first, its left wheels on the right
            left, right = (
                side_of_train("left", tread_wear=2.0 + 0.02 * day),
                side_of_train("right", tread_wear=1.0 + 0.05 * day),
            )
        trackside.roll(f"p{day}", left, right, consist=turned if day == 2 else CONSIST)
    body = call.get("/v1/wheelsets/w2/trend").json()
    trends = {side["side"]: side["quantities"]["tread_wear"] for side in body["sides"]}
    assert trends["left"]["per_day"]["value_mm"] == pytest.approx(0.05)
    assert trends["right"]["per_day"]["value_mm"] == pytest.approx(0.02)
    assert [value["pass_id"] for value in trends["left"]["values"]] == ["p0", "p1", "p2", "p3"]
    assert trends["left"]["fitted"] == 4
    last = call.get("/v1/wheelsets/w2/trend", params={"passes": 2}).json()
    assert last["sides"][0]["passes"] == 2

    found = call.get("/v1/measurements", params={"wheelset": "w2", "side": "left"}).json()
    rows = [(each["pass_id"], each["wheel"]["side"]) for each in found["measurements"]]
    assert rows == [("p0", "left"), ("p1", "left"), ("p2", "right"), ("p3", "left")]
    assert {each["wheel"]["wheelset"] for each in found["measurements"]} == {"w2"}
    of_side = call.get("/v1/measurements", params={"side": "right", "pass": "p2"}).json()
    assert {each["sensor"] for each in of_side["measurements"]} == {"right"}


def test_a_wheel_that_jumps_raises_an_alarm_that_names_both_causes(trackside, call):
    for day, wear in enumerate([1.0, 1.1, 3.2]):
        body = trackside.roll(
            f"p{day}",
            [
                wheel("left", n, at, tread_wear=wear if n == 2 else 1.0)
                for n, at in enumerate(AXLES_S, start=1)
            ],
            side_of_train("right", tread_wear=1.0),
            consist=CONSIST,
        )
        assert len(body["alarms"]) == (day == 2)
    (alarm,) = body["alarms"]
    assert (alarm["kind"], alarm["level"], alarm["wheelset"]) == ("jump", "alarm", "w2")
    assert (alarm["number"], alarm["side"]) == (2, "left")
    assert alarm["value"] == pytest.approx(2.1)
    assert "damaged" in alarm["text"]
    assert "consist that mixes" in alarm["text"]
    assert body["axles"][1]["left"]["jumps"]["tread_wear"]["before"] == "p1"
    (left, _) = call.get("/v1/wheelsets/w2/trend").json()["sides"]
    trend = left["quantities"]["tread_wear"]
    assert [value["jump"] for value in trend["values"]] == [None, None, pytest.approx(2.1)]
    # Before the jump it was another wheel, or another shape: no rate rests on both.
    assert (trend["fitted"], trend["per_day"]) == (1, None)


def test_an_inferred_place_is_in_no_wheels_history(trackside, call):
    """Nobody counted: an axle that both sensors missed would have shifted all that follow."""
    body = trackside.roll("p1", side_of_train("left"), side_of_train("right"), axles=None)
    assert {axle["placing"] for axle in body["axles"]} == {"inferred"}
    body = trackside.roll(
        "p2",
        side_of_train("left", without=(3,)),
        side_of_train("right", without=(3,)),
        axles=None,
        consist=CONSIST,
    )
    assert {axle["placing"] for axle in body["axles"]} == {"unplaced"}
    assert call.get("/v1/wheelsets/w1/trend").status_code == 404


def test_readings_keep_the_regime_they_were_judged_by(trackside):
    limits = LimitsSettings(preset="tsi", regime="depot 7")
    worn = ReadingDocument(value=21.5, u95=0.03, status="ok", alarm="alarm")
    thin = wheel("left", 1, 0.0).model_copy(update={"flange_thickness_10": worn})
    body = trackside.roll(
        "p1", [thin, *side_of_train("left", without=(1,))], side_of_train("right"), limits=limits
    )
    assert {row["regime"] for row in body["wheels"]} == {"depot 7"}
    (alarm,) = body["alarms"]
    assert (alarm["kind"], alarm["quantity"]) == ("limit", "flange_thickness_10")
    assert alarm["text"] == (
        "axle 1 left: flange_thickness_10 21.50 ± 0.03 mm is beyond its limit (depot 7)"
    )


def test_limits_can_be_set_for_every_quantity():
    of_no_wheel = {"preset", "regime", "back_to_back"}
    assert set(LimitsSettings.model_fields) - of_no_wheel == {q.value for q in Quantity}
