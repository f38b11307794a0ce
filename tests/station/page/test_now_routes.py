"""The page Now over HTTP: what it shows of a station, and what its buttons do.

The cameras are doubles; what a browser makes of it is asked in `test_now_browser.py`.
"""

import json
import re
import time
from dataclasses import dataclass, replace
from importlib.resources import files

import pytest
from paged_station import SENSORS, CameraDouble, Paged

from station.capture import CaptureReport, CaptureState, CaptureStatus
from station.errors import StateConflict
from station.settings import SensorSettings
from station.store import AuditEntry, JobKind, Pass, PassState, add_job, pass_in_progress
from station.store.callers import Scope

OF_THE_PAGE = {"HX-Request": "true"}
MARKUP = "<img src=x onerror=alert(1)>"
SHOWN_MARKUP = "&lt;img src=x onerror=alert(1)&gt;"


@dataclass
class TrackDouble(CameraDouble):
    """A capture process that is armed, triggered and finished."""

    plan: object = None
    frames: int = 0

    def status(self):
        idle = super().status()
        if self.plan is None:
            return idle
        return CaptureStatus(
            CaptureState.RECORDING,
            self.sensor,
            session_id=self.plan.session_id,
            recorded=self.frames,
            silent_s=3.0,
            ring_slots=128,
            temperature_c=41.5,
        )

    def arm(self, plan):
        self.plan, self.frames = plan, 0

    def trigger(self):
        if self.plan is None:
            raise StateConflict("nothing is recorded", state="idle")
        self.frames += 1
        return self.frames

    def finish(self, expected_frames=None):
        plan, self.plan = self.plan, None
        return CaptureReport(
            path=plan.path,
            triggered=expected_frames,
            recorded=self.frames,
            lost=0,
            refused=0,
            repeated=0,
            resent_packets=0,
            first_time_ns=None,
            last_time_ns=None,
            events=(),
        )


class Recording(Paged):
    """A station of other sensors, whose cameras record."""

    def __init__(self, root, empty_store, sensors):
        self._sensors = tuple(sensors)
        super().__init__(root, empty_store)

    def begin(self, environment_key):
        settings = self.settings.model_copy(update={"sensors": self._sensors})
        self.captures = {each.id: TrackDouble(each.id) for each in self._sensors}
        self.station = replace(self.station, settings=settings, captures=self.captures)
        super().begin(environment_key)


@pytest.fixture(scope="module")
def station(tmp_path_factory, empty_store):
    """Serve two sensors; the left one is triggered by command."""
    left, right = (SensorSettings(**each) for each in SENSORS)
    sensors = [left.model_copy(update={"trigger": "software"}), right]
    station = Recording(tmp_path_factory.mktemp("now"), empty_store, sensors)
    yield station
    station.close()


@pytest.fixture(scope="module")
def _logged_in(station):
    with station.browser(station.key(Scope.READ, Scope.OPERATE)) as browser:
        browser.headers.update(OF_THE_PAGE)
        yield browser


@pytest.fixture
def operator(station, _logged_in):
    """Log a browser in that may press buttons; a pass that it leaves open is finished."""
    yield _logged_in
    with station.store.look() as session:
        running = pass_in_progress(session)
    if running is not None:
        _logged_in.post("/now/finish", data={"pass_id": running.id})


@pytest.fixture(scope="module")
def reader(station):
    with station.browser(station.key(Scope.READ)) as browser:
        yield browser


def said_in(answer):
    assert answer.status_code == 204, answer.text
    return json.loads(answer.headers["HX-Trigger"])["said"]["text"]


def arm(operator, pass_id, **told):
    return said_in(operator.post("/now/arm", data={"pass_id": pass_id, **told}))


def awaited(browser, address, what):
    """Return a page once something is on it: how the sensors are is a second old at most."""
    until_s = time.monotonic() + 20.0
    while what not in (page := browser.get(address).text):
        assert time.monotonic() < until_s, page
        time.sleep(0.05)
    return page


def test_a_station_without_a_past_says_what_is_not_there_yet(paged):
    with paged.browser(paged.key(Scope.READ)) as reader:
        page = reader.get("/now").text
    assert "No train is expected." in page
    assert "No pass yet." in page
    assert "No work waits." in page
    assert "none in force: its passes are recorded, not measured" in page
    assert "Nothing was recorded in the last 7 days." in page


def test_eight_sensors_have_their_cards_and_no_button_where_none_waits_for_a_command(
    tmp_path, empty_store
):
    names = [f"s{number}" for number in range(8)]
    sensors = [SensorSettings(id=name, address=f"127.43.0.{name[1:]}") for name in names]
    station = Recording(tmp_path, empty_store, sensors)
    with station.browser(station.key(Scope.READ, Scope.OPERATE)) as operator:
        operator.headers.update(OF_THE_PAGE)
        arm(operator, "eight")
        page, live = operator.get("/now").text, operator.get("/now/live").text
        refused = operator.post("/now/trigger")
    station.close()
    for text in (page, live):  # so many are seen at one sight before their pictures are
        overview = text.partition('id="now-overview"')[2].partition("</nav>")[0]
        assert re.findall(r'href="#sensor-(\w+)-name"', overview) == names
        assert overview.count("Armed") == 8
    assert re.findall(r'<figure class="view" data-sensor="(\w+)"', page) == names
    assert "/now/finish" in page
    assert "/now/trigger" not in page
    assert refused.status_code == 409
    assert "no sensor is triggered by command" in refused.json()["detail"]


def test_a_sensor_that_does_not_answer_is_told_and_the_page_comes(station, reader):
    # A look is good for a second.
    station.captures["left"].camera = None
    page = awaited(reader, "/now", 'id="sensor-left-doing" data-doing="silent"')
    station.captures["left"].camera = {}
    assert 'id="sensor-right-doing" data-doing="idle"' in page
    assert "the capture process of left does not answer" in page


def test_every_part_that_is_loaded_anew_has_its_place_on_the_page(reader):
    page, live = reader.get("/now").text, reader.get("/now/live").text
    parts = re.findall(r'id="([\w-]+)" hx-swap-oob="true"', live)
    assert len(parts) == 5 + 3 * 2  # two sensors are seen without an overview
    assert [each for each in parts if f'id="{each}"' not in page] == []
    assert "hx-swap-oob" not in page


def test_all_scripts_of_the_page_are_asked_for_at_once(reader):
    folder = files("station.page.now") / "static"
    scripts = {each.name for each in folder.iterdir() if each.name.endswith(".js")}
    asked = re.findall(r'(?:src|href)="/static/\w+/now/(\w+\.js)"', reader.get("/now").text)
    assert sorted(asked) == sorted(scripts - {"aim.js"})  # which a calibration session begins with


def test_the_part_that_is_loaded_each_second_is_small_for_who_takes_it_so(reader):
    for _ in range(2):  # also of an answer that is given again
        small = reader.get("/now/live", headers={"Accept-Encoding": "gzip"})
        plain = reader.get("/now/live", headers={"Accept-Encoding": "identity"})
        assert small.headers["Content-Encoding"] == "gzip"
        assert int(small.headers["Content-Length"]) < 0.4 * int(plain.headers["Content-Length"])
        assert "Content-Encoding" not in plain.headers
        assert small.headers["Vary"] == plain.headers["Vary"] == "Accept-Encoding"
        assert "sensor-left-doing" in small.text
        assert "sensor-left-doing" in plain.text


def test_no_part_that_is_loaded_anew_holds_the_token_of_a_browser(operator):
    parts = ["/now/live", "/now/last", "/now/desk"]
    assert not any("csrf" in operator.get(part).text for part in parts)


def test_an_armed_pass_is_shown_with_what_each_sensor_has_of_it(station, operator):
    assert arm(operator, "p1", train="RB 17") == "Pass p1 is armed: every sensor records."
    station.captures["left"].frames = 7
    live = awaited(operator, "/now/live", 'data-doing="recording" data-pictured')
    assert "RB 17" in live
    assert re.search(r'<th scope="row">left</th>.*?<td class="num">7</td>', live, re.DOTALL)
    assert 'id="sensor-right-doing" hx-swap-oob="true" data-doing="armed"' in live
    assert "41.5\u202f°C" in live


def test_a_train_that_is_called_markup_is_shown_as_text(operator):
    arm(operator, "p2", train=MARKUP)
    for address in ("/now", "/now/live"):
        page = operator.get(address).text
        assert SHOWN_MARKUP in page
        assert MARKUP not in page
    operator.post("/now/finish", data={"pass_id": "p2"})
    assert SHOWN_MARKUP in operator.get("/now/last").text


def test_the_buttons_are_those_of_the_moment(operator):
    assert 'hx-post="/now/arm"' in operator.get("/now/desk").text
    arm(operator, "p3")
    desk = operator.get("/now/desk").text
    assert 'hx-post="/now/finish"' in desk
    assert 'hx-post="/now/trigger"' in desk
    assert 'hx-post="/now/arm"' not in desk
    operator.post("/now/finish", data={"pass_id": "p3"})
    assert 'hx-post="/now/arm"' in operator.get("/now/desk").text


def test_a_finished_pass_is_the_last_one_and_its_axles_are_those_counted(station, operator):
    arm(operator, "p4")
    for camera in station.captures.values():
        camera.frames = 4
    said = said_in(operator.post("/now/finish", data={"pass_id": "p4", "axles": "4"}))
    assert said.startswith("Pass p4 has ended")
    last = operator.get("/now/last").text
    assert "8 recorded, 0 lost" in last
    with station.store.look() as session:
        assert session.get_one(Pass, "p4").axles == 4


def test_axles_that_nobody_counted_may_be_left_empty(station, operator):
    arm(operator, "p5")
    said_in(operator.post("/now/finish", data={"pass_id": "p5", "axles": ""}))
    with station.store.look() as session:
        assert session.get_one(Pass, "p5").axles is None


def test_a_second_pass_is_refused_in_words(operator):
    arm(operator, "p6")
    refused = operator.post("/now/arm", data={"pass_id": "p6b"})
    assert refused.status_code == 409
    assert "pass p6 is recording; finish it first" in refused.json()["detail"]
    assert arm(operator, "p6") == "Pass p6 was armed already."


@pytest.mark.parametrize("name", ["", "a b", "<b>", "x" * 65])
def test_an_id_that_is_none_is_refused(operator, name):
    assert operator.post("/now/arm", data={"pass_id": name}).status_code == 422


def test_a_command_has_those_sensors_expose_that_wait_for_one(station, operator):
    arm(operator, "p7")
    assert said_in(operator.post("/now/trigger")) == "Frames taken: left 1."
    assert station.captures["right"].frames == 0
    with station.store.look() as session:
        entries = session.query(AuditEntry).filter(AuditEntry.action == "capture").all()
    assert [(each.subject, each.after) for each in entries] == [("p7", {"sensors": ["left"]})]


def test_a_command_without_a_pass_is_refused(operator):
    refused = operator.post("/now/trigger")
    assert refused.status_code == 409
    assert "arm one before you trigger" in refused.json()["detail"]


def test_who_may_only_look_sees_no_button_and_is_refused(reader):
    page = reader.get("/now").text
    assert "/now/arm" not in page
    assert 'data-press="look"' not in page
    assert "Your key may look" in page
    for address in ("/now/arm", "/now/finish", "/now/trigger"):
        assert reader.post(address, data={"pass_id": "p9"}).status_code == 403


def test_work_under_way_is_shown_with_how_far_it_is(station, reader):
    with station.store.change() as session:
        job = add_job(session, "j1", JobKind.MEASURE, MARKUP, at=station.station.now())
        job.progress, job.doing = 0.25, "frame 3 of 12"
    live = reader.get("/now/live").text
    assert SHOWN_MARKUP in live
    assert MARKUP not in live
    assert "frame 3 of 12" in live
    assert 'value="0.25"' in live


def test_a_failed_pass_says_why(station, reader):
    with station.store.change() as session:
        now = station.station.now()
        session.add(Pass(id="f1", state=PassState.FAILED, opened_at=now, reason="no frame came"))
    last = reader.get("/now/last").text
    assert "no frame came" in last
    assert "Failed" in last


def test_the_last_pass_of_a_station_at_work_is_shown_with_its_alarms(quiet_demo):
    last = quiet_demo.ask("/now/last").text
    assert "near its limit" in last
    assert re.search(r"[a-z]_[a-z]+ \d", last) is None  # in words, not in names of programs
    assert "8 measured, 0 not measurable" in last
