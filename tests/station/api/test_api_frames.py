"""Shows that the frames of a recording are listed and seen one by one, wherever they lie in its
files, and that nothing else of the host is."""

from datetime import UTC, datetime

import cv2
import numpy as np
import pytest

from station.recording import Event, EventKind, RecordingWriter, compact, part_path
from station.store import Recording, the

PLACE = "/v1/recordings/r1/frames"
NOON_NS = 1_782_907_200_000_000_000
NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)
PARTS = (5, 4)
"""Frames of each file."""
SHAPE = (600, 1000)


def picture(number):
    """One that no other frame has; of a size of which a chunk holds but two."""
    shown = np.full(SHAPE, number, np.uint8)
    shown[:, 500:] = 200
    return shown


def write(path, numbers):
    with RecordingWriter(path) as writer:
        for number in numbers:
            moment = NOON_NS + number * 1_000_000
            shown = np.ascontiguousarray(picture(number)).data
            writer.write_event("left", Event(EventKind.FRAMES_LOST, moment))
            writer.write_frame("left", 100 + number, moment, moment + 5000, shown, *SHAPE[::-1])


@pytest.fixture
def recorded(served):
    """A recording in two files."""
    path = served.layout.root / "recordings" / "r1.mcap"
    path.parent.mkdir(parents=True)
    first = 1
    for number, count in enumerate(PARTS, start=1):
        write(part_path(path, number), range(first, first + count))
        first += count
    with served.store.change() as session:
        session.add(
            Recording(
                id="r1",
                sensor="left",
                path="recordings/r1.mcap",
                opened_at=NOON,
                closed_at=NOON,
                recorded=sum(PARTS),
                recovered=False,
                files=len(PARTS),
            )
        )
    return path


def change(served, **values):
    with served.store.change() as session:
        row = the(session, Recording, "r1")
        for name, value in values.items():
            setattr(row, name, value)


def seen(reply):
    assert reply.status_code == 200, reply.text
    assert reply.headers["content-type"] == "image/png"
    return cv2.imdecode(np.frombuffer(reply.content, np.uint8), cv2.IMREAD_UNCHANGED)


def listed(call, limit):
    found, after = [], 0
    while after is not None:
        page = call.get(PLACE, params={"limit": limit, "after": after}).raise_for_status().json()
        assert len(page["frames"]) <= limit
        found += page["frames"]
        after = page["next"]
    return found


@pytest.mark.parametrize("compacted", [False, True], ids=["as recorded", "compacted"])
@pytest.mark.parametrize("limit", [2, 200])
def test_frames_are_listed_once_each_whatever_their_files_and_pages(
    recorded, call, limit, compacted
):
    if compacted:
        compact(recorded)
    found = listed(call, limit)
    assert [each["number"] for each in found] == list(range(1, sum(PARTS) + 1))
    assert [each["frame"] for each in found] == [100 + each["number"] for each in found]
    assert {each["sensor"] for each in found} == {"left"}
    assert datetime.fromisoformat(found[1]["time"]) == NOON.replace(microsecond=2000)
    assert datetime.fromisoformat(found[1]["received"]) == NOON.replace(microsecond=2005)


@pytest.mark.parametrize("compacted", [False, True], ids=["as recorded", "compacted"])
@pytest.mark.parametrize("number", [1, 2, 5, 6, 9])
def test_a_frame_is_seen_as_it_was_recorded(recorded, call, number, compacted):
    if compacted:
        compact(part_path(recorded, 2))
    np.testing.assert_array_equal(seen(call.get(f"{PLACE}/{number}/picture")), picture(number))


def test_a_wide_frame_is_made_smaller_where_that_is_asked_for(recorded, call):
    small = seen(call.get(f"{PLACE}/3/picture", params={"max_width": 100}))
    assert small.shape == (60, 100)
    assert (small[:, :50] == 3).all()
    assert (small[:, 50:] == 200).all()
    whole = seen(call.get(f"{PLACE}/3/picture", params={"max_width": 4000}))
    assert whole.shape == SHAPE


@pytest.mark.parametrize(
    ("path", "status", "says"),
    [
        (f"{PLACE}/10/picture", 404, "has 9 frames; there is no frame 10"),
        (f"{PLACE}/0/picture", 422, "number"),
        (f"{PLACE}/x/picture", 422, "number"),
        (f"{PLACE}/1/picture?max_width=0", 422, "max_width"),
        (f"{PLACE}?limit=201", 422, "limit"),
        ("/v1/recordings/r9/frames", 404, "recording 'r9'"),
        ("/v1/recordings/..%2F..%2Fetc%2Fpasswd/frames", 404, "no such address"),
        ("/v1/recordings/..mcap/frames", 422, "recording_id"),
    ],
)
@pytest.mark.usefixtures("recorded")
def test_what_is_no_frame_is_refused(call, path, status, says):
    reply = call.get(path)
    assert reply.status_code == status
    assert says in reply.json()["detail"]


@pytest.mark.parametrize(
    ("values", "says"),
    [({"closed_at": None}, "still runs"), ({"deleted_at": NOON}, "was deleted")],
)
@pytest.mark.usefixtures("recorded")
def test_of_a_recording_that_runs_or_is_gone_no_frame_is_shown(served, call, values, says):
    change(served, **values)
    for path in (PLACE, f"{PLACE}/1/picture"):
        reply = call.get(path)
        assert reply.status_code == 409
        assert says in reply.json()["detail"]


def test_a_damaged_frame_is_said_without_the_folders_of_the_station(served, recorded, call):
    content = bytearray(recorded.read_bytes())
    content[len(content) // 2] ^= 0xFF
    recorded.write_bytes(bytes(content))
    replies = [call.get(f"{PLACE}/{number}/picture") for number in range(1, PARTS[0] + 1)]
    refused = [reply for reply in replies if reply.status_code == 422]
    assert refused
    assert len(refused) < len(replies)
    assert "file 1 of recording r1: damaged" in refused[0].json()["detail"]
    assert str(served.layout.root) not in refused[0].text


def test_a_recording_whose_files_are_gone_is_not_found(recorded, call):
    for number in (1, 2):
        part_path(recorded, number).unlink()
    assert call.get(PLACE).status_code == 404
