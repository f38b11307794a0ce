"""Shows that the events of a recording are listed once each, over all of its files; that they are
kept as they happened is shown with the recorder."""

from datetime import UTC, datetime, timedelta

import pytest

from station.recording import Event, EventKind, RecordingWriter, part_path
from station.store import Recording, the

PLACE = "/v1/recordings/r1/events"
NOON_NS = 1_782_907_200_000_000_000
NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)
TOLD = [
    (EventKind.STARTED, None, 0, {}),
    (EventKind.FRAMES_LOST, 12, 3, {}),
    (EventKind.EXPOSED, 15, 1, {"exposure_us": 250.0}),
    (EventKind.PACKETS_RESENT, 16, 7, {}),
    (EventKind.FINISHED, None, 0, {}),
]


@pytest.fixture
def recorded(served):
    """A recording in two files, with events in both."""
    path = served.layout.root / "recordings" / "r1.mcap"
    path.parent.mkdir(parents=True)
    events = [
        Event(kind, NOON_NS + second * 10**9, f"event {second}", frame, count, values)
        for second, (kind, frame, count, values) in enumerate(TOLD)
    ]
    for number, own in enumerate([events[:2], events[2:]], start=1):
        with RecordingWriter(part_path(path, number)) as writer:
            for event in own:
                writer.write_event("left", event)
    with served.store.change() as session:
        kept = {"id": "r1", "sensor": "left", "path": "recordings/r1.mcap"}
        session.add(Recording(**kept, opened_at=NOON, closed_at=NOON, recovered=False, files=2))
    return path


@pytest.mark.parametrize("limit", [1, 2, 5, 1000])
def test_events_are_listed_once_each_whatever_their_files_and_pages(recorded, call, limit):
    found, after = [], 0
    while after is not None:
        page = call.get(PLACE, params={"limit": limit, "after": after}).raise_for_status().json()
        assert len(page["events"]) <= limit
        found += page["events"]
        after = page["next"]
    assert [each["number"] for each in found] == [1, 2, 3, 4, 5]
    told = [(each["kind"], each["frame"], each["count"], each["values"]) for each in found]
    assert told == TOLD
    times = [datetime.fromisoformat(each["time"]) for each in found]
    assert times == [NOON + timedelta(seconds=second) for second in range(5)]
    assert [each["loss"] for each in found] == [False, True, False, False, False]


def test_events_of_a_recording_that_runs_or_was_deleted_are_refused(recorded, call, served):
    for changed, state in (
        ({"closed_at": None}, "recording"),
        ({"closed_at": NOON, "deleted_at": NOON}, "deleted"),
    ):
        with served.store.change() as session:
            row = the(session, Recording, "r1")
            for name, value in changed.items():
                setattr(row, name, value)
        reply = call.get(PLACE)
        assert (reply.status_code, reply.json()["state"]) == (409, state)


def test_events_of_no_recording_are_not_found(call):
    assert call.get(PLACE).status_code == 404


def test_damaged_recording_is_told_without_the_place_it_lies_in(recorded, call, served):
    recorded.write_bytes(recorded.read_bytes()[:-20])
    reply = call.get(PLACE)
    assert reply.status_code >= 400
    assert "file 1 of recording r1" in reply.json()["detail"]
    assert str(served.layout.root) not in reply.text
