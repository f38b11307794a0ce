"""Shows that a station does not start on a store that is damaged or out of reach, and what it says
instead."""

from datetime import UTC, datetime

import pytest

from station.errors import InputUnusable, StoreUnusable
from station.store import Pass, PassState, Store, ensure_sound, migrate, sqlite_url

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)


def test_a_whole_store_and_one_that_is_not_yet_made_are_sound(any_url):
    ensure_sound(any_url)
    migrate(any_url)
    ensure_sound(any_url)


def test_a_damaged_file_is_refused_with_the_cure(tmp_path):
    path = tmp_path / "station.sqlite"
    migrate(sqlite_url(path))
    store = Store.open(sqlite_url(path))
    with store.change() as session:
        for n in range(500):
            session.add(Pass(id=f"p{n}", state=PassState.DONE, opened_at=NOON))
    store.close()
    content = bytearray(path.read_bytes())
    content[-8192:-4096] = bytes(range(256)) * 16
    path.write_bytes(content)
    with pytest.raises(StoreUnusable, match=r"damaged .* station restore FILE") as refusal:
        ensure_sound(sqlite_url(path))
    assert "\n" not in str(refusal.value)


def test_a_file_that_is_no_database_is_refused(tmp_path):
    path = tmp_path / "station.sqlite"
    path.write_text("something else " * 100)
    with pytest.raises(StoreUnusable, match="file is not a database"):
        ensure_sound(sqlite_url(path))


def test_a_server_that_does_not_answer_is_named_without_its_password(tmp_path):
    url = f"postgresql://treadline:secret@/station?host={tmp_path}"
    with pytest.raises(StoreUnusable, match="start PostgreSQL, or correct store_url") as refusal:
        ensure_sound(url)
    assert "secret" not in str(refusal.value)
    assert "\n" not in str(refusal.value)
    store = Store.open(url)
    with pytest.raises(StoreUnusable, match="try again"):
        store.ensure_answers()
    store.close()


@pytest.mark.parametrize(
    "url", ["mysql://me:secret@host/station", "sqlite://", "postgresql://me:secret@host", "secret"]
)
def test_another_database_is_refused_without_repeating_its_url(url):
    with pytest.raises(InputUnusable, match="allowed: postgresql://") as refusal:
        Store.open(url)
    assert "secret" not in str(refusal.value)
