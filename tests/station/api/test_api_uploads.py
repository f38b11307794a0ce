"""Shows that recordings of elsewhere are taken in whole and sound or not at all, and that whatever
else is sent leaves nothing behind."""

import hashlib
import socket
import time

import numpy as np
import pytest
from test_api_calibration import make_ready

from station.operations import Uploads
from station.recording import RecordingWriter
from station.store import Recording, the
from station.store.callers import Scope

PLACE = "/v1/recordings"
MAGIC = b"\x89MCAP0\r\n"
KIND = {"Content-Type": "application/octet-stream"}


def a_recording(folder, sensors=("left",), frames=3, metadata=None):
    path = folder / f"{len(list(folder.iterdir()))}.mcap"
    picture = np.full(8 * 16, 40, np.uint8).data
    with RecordingWriter(path, metadata=metadata) as writer:
        for number in range(1, frames + 1):
            for sensor in sensors:
                writer.write_frame(sensor, number, number, number, picture, 16, 8)
    return path.read_bytes()


def files_in(served):
    folder = served.layout.root / served.layout.uploads
    return sorted(path.name for path in folder.iterdir()) if folder.is_dir() else []


def upload(client, content, **headers):
    return client.post(PLACE, content=content, headers=KIND | headers)


@pytest.fixture(scope="module")
def elsewhere(tmp_path_factory):
    return tmp_path_factory.mktemp("elsewhere")


@pytest.fixture(scope="module")
def content(elsewhere):
    return a_recording(elsewhere)


def test_an_upload_is_a_recording_like_others_and_the_same_one_when_it_comes_again(
    served, call, content
):
    reply = upload(call, content)
    assert reply.status_code == 201
    body = reply.json()
    assert reply.headers["Location"] == f"{PLACE}/{body['id']}"
    assert (body["sensor"], body["recorded"], body["lost"]) == ("left", 3, 0)
    assert (body["pass_id"], body["session_id"]) == (None, None)
    again = upload(call, content)
    assert (again.status_code, again.json()) == (200, body)
    assert call.get(PLACE).json()["recordings"] == [body]
    assert call.get(reply.headers["Location"]).json() == body
    with served.store.look() as session:
        row = the(session, Recording, body["id"])
    assert (served.layout.root / row.path).read_bytes() == content
    assert row.sha256 == hashlib.sha256(content).hexdigest()
    assert len(files_in(served)) == 1
    # What was recorded elsewhere is not counted among the frames of the station's cameras.
    assert "station_frames{" not in call.get("/metrics").text


def test_a_file_of_a_recording_is_fetched_whole_or_in_part_by_its_number(call, content):
    place = upload(call, content).headers["Location"]
    reply = call.get(f"{place}/files/1")
    assert reply.content == content
    assert reply.headers["content-type"] == "application/octet-stream"
    assert reply.headers["content-disposition"].startswith("attachment")
    part = call.get(f"{place}/files/1", headers={"Range": "bytes=8-15"})
    assert (part.status_code, part.content) == (206, content[8:16])
    assert call.get(f"{place}/files/1", headers={"Range": "bytes=x"}).status_code in {400, 200}
    for number, status in (("2", 404), ("0", 422), ("-1", 422), ("1.mcap", 422)):
        assert call.get(f"{place}/files/{number}").status_code == status, number
    call.delete(place)
    assert call.get(f"{place}/files/1").status_code == 409


def test_a_recording_that_still_runs_is_not_fetched(call):
    call.put("/v1/passes/p1", json={})
    assert call.get(f"{PLACE}/pass.p1.left/files/1").status_code == 409
    call.post("/v1/passes/p1/finish", json={"axles": 4})
    assert call.get(f"{PLACE}/pass.p1.left/files/1").status_code == 404


def test_a_calibration_may_be_ordered_from_an_upload_which_then_stays(served, call, content):
    name = upload(call, content).json()["id"]
    order = {"sensor": "left", "recordings": [name], "target": "dots:7x8:12"}
    calibration = call.post("/v1/calibrations", json=order).json()["id"]
    assert call.delete(f"{PLACE}/{name}").status_code == 409
    make_ready(served, calibration)
    place = "/v1/sensors/left/active-calibration"
    call.put(place, json={"calibration": calibration}, headers={"If-None-Match": "*"})
    reply = call.delete(f"{PLACE}/{name}")
    assert reply.status_code == 409
    assert "in force" in reply.json()["detail"]
    assert len(files_in(served)) == 1


def test_a_deleted_upload_is_gone_from_the_disk_and_may_come_again(served, call, content):
    name = upload(call, content).json()["id"]
    deleted = call.delete(f"{PLACE}/{name}")
    assert deleted.json()["deleted_why"] == "deleted by environment"
    assert call.delete(f"{PLACE}/{name}").json() == deleted.json()
    assert files_in(served) == []
    assert upload(call, content).json()["id"] != name


def test_what_the_station_recorded_itself_is_not_deleted_by_a_call(call):
    call.put("/v1/passes/p1", json={})
    call.post("/v1/passes/p1/finish", json={"axles": 4})
    reply = call.delete(f"{PLACE}/pass.p1.left")
    assert reply.status_code == 409
    assert "the station's own" in reply.json()["detail"]


def damaged(content):
    middle = len(content) // 2
    return content[:middle] + bytes([content[middle] ^ 255]) + content[middle + 1 :]


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda content: content[:-100], "the upload"),
        (damaged, "damaged"),
        (lambda content: MAGIC + b"\xff" * 5000 + MAGIC, "the upload"),
    ],
    ids=["cut short", "a bit flipped", "rubbish between"],
)
def test_what_is_no_sound_recording_is_refused_and_leaves_nothing(
    served, call, content, spoil, says
):
    reply = upload(call, spoil(content))
    assert reply.status_code == 422
    assert says in reply.json()["detail"]
    # Where the station keeps its files is nobody's business.
    assert str(served.layout.root) not in reply.text
    assert files_in(served) == []
    assert call.get(PLACE).json()["recordings"] == []


@pytest.mark.parametrize(
    ("made_as", "says"),
    [
        ({"sensors": ("left", "right")}, "2 sensors"),
        ({"sensors": ("../../etc",)}, "named with lower-case"),
        ({"metadata": {"session": {"id": "x", "part": "2"}}}, "one of several files"),
    ],
    ids=["two sensors", "a path for a name", "a later part"],
)
def test_what_is_not_one_recording_of_one_sensor_is_refused(served, call, elsewhere, made_as, says):
    reply = upload(call, a_recording(elsewhere, **made_as))
    assert reply.status_code == 422
    assert says in reply.json()["detail"]
    assert files_in(served) == []


@pytest.mark.parametrize(
    "content", [b"#!/bin/sh\nrm -rf /", b"\x89PNG\r\n\x1a\n", b"\x89MCAP1\r\n"]
)
def test_what_does_not_begin_as_a_recording_is_refused_at_once(served, call, content):
    reply = upload(call, content)
    assert reply.status_code == 422
    assert "not a recording (MCAP)" in reply.json()["detail"]
    assert files_in(served) == []


@pytest.mark.parametrize("served", [{"web": {"upload_mb": 1}}], indirect=True)
def test_an_upload_larger_than_the_settings_allow_is_refused_before_it_is_sent(served, call):
    reply = upload(call, MAGIC + bytes(1_000_001))
    assert reply.status_code == 422
    assert "at most 1 MB" in reply.json()["detail"]


@pytest.mark.parametrize(
    "served",
    [
        {"web": {"uploads_gb": 1e-6}},
        {"storage": {"quota_gb": 1e-6}},
        {"storage": {"keep_free_gb": 1e6}},
    ],
    indirect=True,
)
def test_an_upload_that_would_not_fit_is_507(served, call, content):
    reply = upload(call, content)
    assert reply.status_code == 507
    assert files_in(served) == []


def test_an_upload_says_its_length(call):
    reply = upload(call, (piece for piece in [MAGIC]))
    assert reply.status_code == 400
    assert "Content-Length" in reply.json()["detail"]


@pytest.mark.parametrize("served", [{"web": {"body_s": 0.3}}], indirect=True)
def test_an_upload_that_stops_or_breaks_off_leaves_nothing_and_makes_room_for_the_next(
    served, call, content
):
    host, port = served.url.removeprefix("http://").split(":")
    head = (
        f"POST {PLACE} HTTP/1.1\r\nHost: x\r\nContent-Length: 5000\r\n"
        f"Authorization: {call.headers['Authorization']}\r\n\r\n"
    )
    with socket.create_connection((host, int(port)), timeout=60.0) as connection:
        connection.sendall(head.encode() + MAGIC)
        assert b" 408 " in connection.recv(1000)
    with socket.create_connection((host, int(port)), timeout=60.0) as connection:
        connection.sendall(head.encode() + MAGIC)
    until_s = time.monotonic() + 20.0
    # Until the station has heard that the caller went away, nothing else is taken in.
    while (status := upload(call, content).status_code) == 409 and time.monotonic() < until_s:
        time.sleep(0.05)
    assert status == 201


def test_one_recording_is_taken_in_at_a_time(served, call, content):
    uploads = served.app.state.parts.uploads
    running = uploads.begin(100)
    assert upload(call, content).status_code == 409
    uploads.abandon(running)
    uploads.abandon(running)
    assert upload(call, content).status_code == 201


def test_what_a_dead_api_process_left_is_removed_and_what_is_known_stays(served, call, content):
    upload(call, content)
    folder = served.layout.root / served.layout.uploads
    for name in ("a.part", "b.mcap"):
        (folder / name).write_bytes(MAGIC)
    Uploads(served.station).take_up()
    assert [name for name in files_in(served) if name in {"a.part", "b.mcap"}] == []
    assert len(files_in(served)) == 1


def test_uploading_needs_a_key_that_may_calibrate(served, content):
    for scope, status in ((Scope.READ, 403), (Scope.OPERATE, 403), (Scope.CALIBRATE, 201)):
        with served.client(served.key(scope)) as client:
            assert upload(client, content).status_code == status
    with served.client(None) as client:
        assert upload(client, content).status_code == 401
