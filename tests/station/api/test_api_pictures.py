"""Shows what is seen of a sensor over HTTP: the newest frame with the stripe of that very frame,
once each, and a look through an idle camera by those who may."""

import json
import os
import threading
import time
from datetime import UTC, datetime

import cv2
import numpy as np
import pytest
from anyio import create_task_group, run, sleep, to_thread

from station.api.refusals import PicturesBusy
from station.api.turns import Turns
from station.api.view_answers import FrameStripeModel, ViewModel
from station.capture import Look
from station.errors import CameraLost, StateConflict
from station.recording import RecordingWriter
from station.store import Recording, the
from station.store.callers import Scope
from station.viewing import Viewer

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)
NOON_NS = 1_782_907_200_000_000_000
PICTURE, VIEW = "/v1/sensors/left/picture", "/v1/sensors/left/view"
HEIGHT, WIDTH = 300, 800
JPEG = "image/jpeg"


def striped(number):
    """A frame whose stripe tells its number."""
    rows = np.arange(HEIGHT)[:, None]
    bell = 150.0 * np.exp(-0.5 * ((rows - row_of(number)) / 2.0) ** 2)
    noise = np.random.default_rng(number).normal(20.0, 1.5, (HEIGHT, WIDTH))
    return np.clip(np.rint(bell + noise), 0, 255).astype(np.uint8)


def row_of(number):
    return 40.0 + 10.0 * number


def write(writer, number):
    moment = NOON_NS + number * 1_000_000
    view = striped(number).data.cast("B")
    writer.write_frame("left", 100 + number, moment, moment + 5000, view, WIDTH, HEIGHT)


class Recorded:
    """Recordings of a sensor as the store knows them."""

    def __init__(self, served):
        self.served = served
        self.writers = []

    def begin(self, name, **values):
        path = self.served.layout.root / f"{name}.mcap"
        with self.served.store.change() as session:
            minutes = len(self.writers)
            opened = NOON.replace(minute=minutes)
            row = {"sensor": "left", "path": path.name, "opened_at": opened, "recovered": False}
            session.add(Recording(id=name, **{**row, **values}))
        self.writers.append(RecordingWriter(path))
        return self.writers[-1]

    def end(self, name, frames):
        self.writers[-1].finish()
        with self.served.store.change() as session:
            row = the(session, Recording, name)
            row.closed_at, row.recorded = NOON, frames


@pytest.fixture
def recorded(served):
    made = Recorded(served)
    yield made
    for writer in made.writers:
        writer.finish()


def give(capture, number):
    """Have the double of a sensor see a frame when somebody looks through it."""
    looks = []

    def look():
        descriptor = os.memfd_create("look")
        os.write(descriptor, striped(number).tobytes())
        looks.append(Look(descriptor, WIDTH, HEIGHT, NOON_NS))
        return looks[-1]

    capture.look = look
    return looks


def refuse(capture, error):
    def look():
        raise error

    capture.look = look


def decoded(reply):
    assert reply.status_code == 200, reply.text
    return cv2.imdecode(np.frombuffer(reply.content, np.uint8), cv2.IMREAD_UNCHANGED)


def newer(call, tag):
    """Ask until there is a newer frame: who looks too often is given the same."""
    deadline = time.monotonic() + 20.0
    headers = {} if tag is None else {"If-None-Match": tag}
    while (reply := call.get(PICTURE, headers=headers)).status_code == 304:
        assert time.monotonic() < deadline
    return reply


def test_the_newest_frame_is_shown_while_it_is_recorded_and_each_but_once(call, recorded):
    writer = recorded.begin("p1-left")
    tag = None
    for number in (1, 2):
        write(writer, number)
        reply = newer(call, tag)
        assert decoded(reply).shape == (240, 640)
        assert reply.headers["content-type"] == JPEG
        told = {name: reply.headers[f"Treadline-{name}"] for name in ("Recording", "Number")}
        assert told == {"Recording": "p1-left", "Number": str(number)}
        assert reply.headers["Treadline-Frame"] == str(100 + number)
        assert reply.headers["Treadline-Time"] == f"2026-07-01T12:00:00.00{number}000Z"
        assert reply.headers["Treadline-Received"] == f"2026-07-01T12:00:00.00{number}005Z"
        tag = reply.headers["ETag"]
        again = call.get(PICTURE, headers={"If-None-Match": tag})
        assert (again.status_code, again.content, again.headers["ETag"]) == (304, b"", tag)
        assert again.headers["Cache-Control"] == "no-store"


def test_the_stripe_is_that_of_the_picture_beside_it(call, recorded):
    writer = recorded.begin("p1-left")
    for number in (1, 2, 3):
        write(writer, number)
    reply = call.get(VIEW, params={"max_width": 200})
    told = ViewModel.model_validate(reply.json(), extra="forbid")
    assert (told.sensor, told.recording, told.number, told.frame) == ("left", "p1-left", 3, 103)
    assert (told.width_px, told.height_px) == (WIDTH, HEIGHT)
    assert (told.picture.width_px, told.picture.height_px) == (200, 75)
    assert told.stripe.points > 0.9 * WIDTH
    assert np.abs(np.array(told.stripe.v_px) - row_of(3)).max() < 0.2
    assert reply.headers["Treadline-Number"] == "3"
    served_tag = {"If-None-Match": reply.headers["ETag"]}
    assert call.get(VIEW, headers=served_tag).status_code == 304


def test_where_nothing_new_was_recorded_yet_the_last_frame_of_before_is_shown(call, recorded):
    write(recorded.begin("p1-left"), 5)
    recorded.end("p1-left", 1)
    recorded.begin("p2-left")
    recorded.end("p2-left", 0)
    writer = recorded.begin("p3-left")
    assert call.get(PICTURE).headers["Treadline-Recording"] == "p1-left"
    write(writer, 1)
    reply = newer(call, '"p1-left.1"')
    assert reply.headers["Treadline-Recording"] == "p3-left"


def test_while_nothing_is_recorded_who_has_the_last_frame_asks_no_process(served, call, recorded):
    write(recorded.begin("p1-left"), 5)
    recorded.end("p1-left", 1)
    tag = call.get(PICTURE).headers["ETag"]
    served.app.state.parts.showing._viewer = None
    assert call.get(PICTURE, headers={"If-None-Match": tag}).status_code == 304


@pytest.mark.parametrize(
    "values",
    [{"sha256": "0" * 64}, {"deleted_at": NOON}, {"sensor": "right"}],
    ids=["uploaded", "deleted", "of another sensor"],
)
def test_what_the_sensor_did_not_record_is_not_its_newest_frame(call, recorded, values):
    write(recorded.begin("r1", **values), 1)
    recorded.end("r1", 1)
    reply = call.get(PICTURE)
    assert reply.status_code == 404
    assert "sensor left has recorded no frame" in reply.json()["detail"]


@pytest.mark.parametrize(
    ("path", "status", "says"),
    [
        ("/v1/sensors/none/picture", 404, "sensor 'none'"),
        ("/v1/sensors/none/view?source=look", 404, "sensor 'none'"),
        ("/v1/sensors/left/picture?max_width=8", 422, "max_width"),
        ("/v1/sensors/left/view?source=dream", 422, "source"),
    ],
)
def test_what_cannot_be_shown_is_refused(call, path, status, says):
    reply = call.get(path)
    assert reply.status_code == status
    assert says in reply.json()["detail"]


def test_a_look_shows_what_the_camera_sees_now_and_is_let_go(served, call):
    looks = give(served.captures["left"], 4)
    reply = call.get(VIEW, params={"source": "look"})
    told = ViewModel.model_validate(reply.json(), extra="forbid")
    assert (told.recording, told.number, told.frame) == (None, None, None)
    assert told.received == NOON
    assert np.abs(np.array(told.stripe.v_px) - row_of(4)).max() < 0.2
    assert told.focus.width_px == pytest.approx(2.0, rel=0.05)
    assert told.brightness.max_counts < 200
    assert "ETag" not in reply.headers
    assert reply.headers["Cache-Control"] == "no-store"
    assert call.get(PICTURE, params={"source": "look"}).headers["content-type"] == JPEG
    assert len(looks) == 2
    for look in looks:
        with pytest.raises(OSError, match="Bad file descriptor"):
            os.fstat(look.descriptor)


def test_names_of_no_sensor_leave_nothing_behind(served, call):
    for number in range(3):
        assert call.get(f"/v1/sensors/s{number}/view?source=look").status_code == 404
    assert not served.app.state.parts.turns._of


def test_a_look_needs_the_scope_to_operate_or_to_calibrate(served):
    looks = give(served.captures["left"], 4)
    for scope, status in ((Scope.READ, 403), (Scope.OPERATE, 200), (Scope.CALIBRATE, 200)):
        with served.client(served.key(scope)) as client:
            assert client.get(PICTURE, params={"source": "look"}).status_code == status
    assert len(looks) == 2


@pytest.mark.parametrize(
    ("error", "status", "state"),
    [
        (StateConflict("sensor left is recording", state="recording"), 409, "recording"),
        (CameraLost("the camera stopped answering"), 503, None),
    ],
)
def test_a_look_that_cannot_be_taken_is_answered_with_why(served, call, error, status, state):
    refuse(served.captures["left"], error)
    reply = call.get(VIEW, params={"source": "look"})
    assert reply.status_code == status
    assert reply.json().get("state") == state


def test_any_frame_of_a_recording_is_shown_with_its_stripe(call, recorded):
    writer = recorded.begin("r1")
    for number in (1, 2, 3):
        write(writer, number)
    recorded.end("r1", 3)
    place = "/v1/recordings/r1/frames/2"
    exact = call.get(f"{place}/picture")
    np.testing.assert_array_equal(decoded(exact), striped(2))
    small = call.get(f"{place}/picture", params={"format": "jpeg", "max_width": 160})
    assert small.headers["content-type"] == JPEG
    assert decoded(small).shape == (60, 160)
    assert len(small.content) < 8_000
    reply = call.get(f"{place}/stripe")
    told = FrameStripeModel.model_validate(json.loads(reply.content), extra="forbid")
    assert (told.recording, told.number, told.frame) == ("r1", 2, 102)
    assert np.abs(np.array(told.stripe.v_px) - row_of(2)).max() < 0.2
    for each in (exact, small, reply):
        assert each.headers["Cache-Control"].startswith("private, max-age=")
    assert call.get("/v1/recordings/r1/frames/4/stripe").status_code == 404
    assert call.get(f"{place}/picture", params={"format": "gif"}).status_code == 422


def test_the_viewing_process_ends_with_the_app(served, recorded, monkeypatch):
    monkeypatch.setattr("station.api.app.Viewer", Viewer)
    served.end()
    served.begin()
    write(recorded.begin("r1"), 1)
    with served.client() as call:
        call.get(PICTURE).raise_for_status()
    viewer = served.app.state.parts.showing._viewer
    assert viewer.pid is not None
    served.end()
    assert viewer.pid is None


def test_a_call_too_many_is_told_to_come_again_and_no_one_waits_for_anothers_camera():
    free, refused, made = threading.Event(), [], []

    async def ask(turns, sensor):
        try:
            made.append(await turns.take(sensor, lambda: free.wait(20.0) and sensor))
        except PicturesBusy as error:
            refused.append(error)

    async def crowd():
        turns = Turns()
        async with create_task_group() as asking:
            for _ in range(40):
                asking.start_soon(ask, turns, "left")
                await sleep(0)
            asking.start_soon(ask, turns, None)
            while not refused:
                await sleep(0.01)
            await to_thread.run_sync(free.set)

    run(crowd)
    assert len(made) + len(refused) == 41
    assert len(refused) == 15  # one is made, twenty-four wait
    assert refused[0].retry_after_s == 1
