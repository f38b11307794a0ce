"""Shows that what is on the disk and in no row is found, and nothing of what the store knows."""

import pytest
from newest_schema import make_store

from station.operations import utc_now
from station.storage import unnamed_recordings
from station.store import Recording, Store, sqlite_url


@pytest.fixture
def store(tmp_path):
    url = sqlite_url(tmp_path / "station.sqlite")
    make_store(url)
    store = Store.open(url)
    with store.change() as session:
        session.add(
            Recording(
                id="pass.p1.left",
                sensor="left",
                path="recordings/passes/p1/left.mcap",
                opened_at=utc_now(),
                recovered=False,
            )
        )
    yield store
    store.close()


def files(tmp_path, *names):
    for name in names:
        path = tmp_path / "recordings" / "passes" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()


def test_a_recording_with_all_its_parts_is_known_by_its_row(store, tmp_path):
    files(tmp_path, "p1/left.mcap", "p1/left.0002.mcap", "p1/left.0003.mcap.active")
    assert unnamed_recordings(store, tmp_path) == []


def test_recordings_that_no_row_names_are_found_whole_or_unfinished_and_left(store, tmp_path):
    strange = ["p0/left.mcap", "p1/left.0003.mcap", "p2/left.mcap.active"]
    files(tmp_path, "p1/left.mcap.active", *strange, "p2/left.mcap.compacting", "notes.txt")
    passes = tmp_path / "recordings" / "passes"
    found = unnamed_recordings(store, tmp_path)
    assert [str(path.relative_to(passes)) for path in found] == strange
    assert all(path.exists() for path in found)


def test_a_station_that_recorded_nothing_yet_has_none(store, tmp_path):
    assert unnamed_recordings(store, tmp_path) == []
