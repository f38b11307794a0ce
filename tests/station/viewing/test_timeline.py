"""Shows that the time line of a recording is true to its frames and events, of a size that does not
grow with it, and made anew only where the files are others."""

import json
from dataclasses import replace

import pytest
from viewing_samples import HEIGHT, NOON_NS, WIDTH, write_striped

from station.recording import Event, EventKind, FrameTable, RecordingWriter, compact
from station.viewing import Form, ViewOrder
from station.viewing import tables as tables_
from station.viewing.finding import Finder
from station.viewing.process import Desk
from station.viewing.tables import Tables
from station.viewing.timeline import timeline_json

S_NS = 1_000_000_000
DARK = memoryview(bytes(WIDTH * HEIGHT))


@pytest.fixture
def path(tmp_path):
    return tmp_path / "a.mcap"


def write_dark(writer, frame_id, at_s):
    moment = NOON_NS + round(at_s * S_NS)
    writer.write_frame("left", frame_id, moment, moment, DARK, WIDTH, HEIGHT)


def note(writer, kind, at_s, frame_id=None):
    event = Event(kind, NOON_NS + round(at_s * S_NS), f"at {at_s}", frame_id, 1)
    writer.write_event("left", event)


def timeline(path, *frame_ids):
    return timeline_json(FrameTable.of([path]), frame_ids)


def test_every_frame_is_in_the_part_of_the_time_when_it_came(path):
    with RecordingWriter(path) as writer:
        note(writer, EventKind.STARTED, 0.0)
        for frame_id, at_s in [(1, 2.0), (2, 2.001), (3, 5.0), (4, 10.0)]:
            write_dark(writer, frame_id, at_s)
    told = timeline(path)
    assert (told["from"], told["seconds"], told["frames"]) == ("2026-07-01T12:00:00.000000Z", 10, 4)
    frames, first = told["bins"]["frames"], told["bins"]["first"]
    parts = len(frames)
    assert {place: count for place, count in enumerate(frames) if count} == {
        parts // 5: 2,
        parts // 2: 1,
        parts - 1: 1,
    }
    assert (first[0], first[parts // 5], first[parts // 5 + 1], first[-1]) == (1, 1, 3, 4)


def test_places_of_frames_are_told_by_the_ids_of_the_camera(path):
    with RecordingWriter(path) as writer:
        for frame_id, at_s in [(11, 0.0), (13, 1.5)]:
            write_dark(writer, frame_id, at_s)
    assert timeline(path, 13, 12)["places"] == {"13": {"number": 2, "at_s": 1.5}}


def test_an_event_leads_to_the_frame_it_concerns_else_to_the_last_one_before(path):
    with RecordingWriter(path) as writer:
        for frame_id, at_s in [(1, 1.0), (2, 2.0), (5, 3.0), (6, 4.0)]:
            write_dark(writer, frame_id, at_s)
        note(writer, EventKind.PACKETS_RESENT, 2.5)
        note(writer, EventKind.STARTED, 0.5)
        note(writer, EventKind.FRAMES_LOST, 5.0, frame_id=3)
    told = [(each["kind"], each["number"], each["loss"]) for each in timeline(path)["events"]]
    assert told == [("started", 1, False), ("packets_resent", 2, False), ("frames_lost", 3, True)]


def test_where_the_camera_counted_anew_an_event_is_placed_by_its_time(path):
    with RecordingWriter(path) as writer:
        for frame_id, at_s in [(1, 1.0), (2, 2.0), (1, 3.0)]:
            write_dark(writer, frame_id, at_s)
        note(writer, EventKind.FRAMES_LOST, 3.5, frame_id=1)
    assert timeline(path)["events"][0]["number"] == 3


def test_of_too_many_events_losses_stay_and_the_rest_is_counted(path):
    with RecordingWriter(path) as writer:
        write_dark(writer, 1, 0.0)
        for place in range(300):
            kind = EventKind.FRAMES_LOST if place >= 295 else EventKind.PACKETS_RESENT
            note(writer, kind, place)
            note(writer, EventKind.EXPOSED, place)  # one a frame: no news
    told = timeline(path)
    assert (len(told["events"]), told["events_left_out"]) == (200, 100)
    assert sum(each["loss"] for each in told["events"]) == 5
    times = [each["at_s"] for each in told["events"]]
    assert times == sorted(times)


def test_a_time_line_is_a_form_of_the_viewing_process(path):
    with RecordingWriter(path) as writer:
        write_striped(writer, range(1, 4), "left")
    order = ViewOrder(Form.TIMELINE, path, about={"recording": "r1"}, frame_ids=(102,))
    again = ViewOrder.from_json(json.loads(json.dumps(order.to_json())), None)
    assert again == order
    desk = Desk(Finder())
    told = json.loads(desk.view(again).content)
    assert (told["recording"], told["frames"]) == ("r1", 3)
    assert told["places"]["102"]["number"] == 2
    others = replace(order, frame_ids=(103,))
    assert list(json.loads(desk.view(others).content)["places"]) == ["103"]


def test_a_table_is_read_again_only_when_the_files_are_others(path, monkeypatch):
    read = []

    class Counted(FrameTable):
        @classmethod
        def of(cls, files):
            read.append(files)
            return FrameTable.of(files)

    monkeypatch.setattr(tables_, "FrameTable", Counted)
    with RecordingWriter(path) as writer:
        write_striped(writer, range(1, 4), "left")
    tables = Tables()
    assert len(tables.of(path)) == len(tables.of(path)) == 3
    assert len(read) == 1
    compact(path)
    assert tables.of(path).frame(2)[0].frame_id == 102
    assert len(read) == 2
