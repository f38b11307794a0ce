"""Which files go, by what the store knows of their recordings; a disk is not filled for it."""

from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
from newest_schema import make_store
from structlog.testing import capture_logs

from station.errors import DiskFull
from station.recording import RecordingWriter, RotatingWriter, Rotation, frames, is_compact
from station.settings import StorageSettings
from station.storage import compact_recording, due_for_compacting, tidy
from station.storage.tidying import files_of_recording
from station.store import (
    Activation,
    Calibration,
    CalibrationSession,
    CalibrationState,
    Measurement,
    Pass,
    PassState,
    Recording,
    SessionState,
    Store,
    sqlite_url,
    the,
)

NOW = datetime(2026, 7, 1, 12, tzinfo=UTC)
ALL_GO = StorageSettings(keep_days=1e-6)


class Kept:
    """A store and the files of its recordings."""

    def __init__(self, root):
        self.root = root
        url = sqlite_url(root / "station.sqlite")
        make_store(url)
        self.store = Store.open(url)
        self._age = 0

    def add(self, *rows):
        with self.store.change() as session:
            for row in rows:
                session.add(row)
                session.flush()

    def recording(self, name, *, measured=False, **fields):
        """A recording in its row and on the disk; the later made, the younger."""
        self._age += 1
        opened_at = NOW - timedelta(days=100 - self._age)
        path = f"recordings/{name}.mcap"
        row = Recording(
            id=name, sensor="left", path=path, opened_at=opened_at, closed_at=opened_at,
            recorded=2, recovered=False, **fields,
        )  # fmt: skip
        self.add(row)
        if measured:
            self.add(
                Measurement(
                    recording_id=name, frame=1, calibration_id=fields["calibration_id"],
                    sensor="left", pass_id=fields["pass_id"], reference="S1002", software="none",
                    measured_at=NOW, wheel={},
                )
            )  # fmt: skip
        write(self.root / path)

    def of_pass(self, name, state=PassState.DONE, *, measured=True, calibration_id="in-force"):
        self.add(Pass(id=name, state=state, opened_at=NOW))
        self.recording(name, pass_id=name, calibration_id=calibration_id, measured=measured)

    def of_session(self, name):
        self.add(
            CalibrationSession(
                id=name, state=SessionState.RECORDED, sensor="left", target="dots:7x8:12",
                pictures=2, opened_at=NOW,
            )
        )  # fmt: skip
        self.recording(name, session_id=name)

    def calibration(self, name, *recordings, state=CalibrationState.READY, laser_off=()):
        self.add(
            Calibration(
                id=name, state=state, sensor="left", target="dots:7x8:12", method="joint",
                recording_ids={"recordings": list(recordings), "laser_off": list(laser_off)},
                created_at=NOW, job_id="job",
            )
        )  # fmt: skip

    def in_force(self, name, version):
        self.add(
            Activation(
                sensor="left", version=version, calibration_id=name, activated_at=NOW,
                activated_by="test",
            )
        )  # fmt: skip

    def left(self):
        return {file.name for file in self.root.glob("recordings/*")}

    def tidy(self, settings=ALL_GO, **arguments):
        gone = tidy(self.store, self.root, settings, NOW, **arguments)
        return [each.candidate.recording_id for each in gone]


def write(path):
    path.parent.mkdir(exist_ok=True)
    flat = np.zeros((48, 64), np.uint8)
    with RecordingWriter(path) as writer:
        for number in (1, 2):
            writer.write_frame("left", number, number, number, flat.data.cast("B"), 64, 48)


@pytest.fixture
def kept(tmp_path):
    kept = Kept(tmp_path)
    kept.calibration("old")
    kept.calibration("in-force")
    kept.in_force("old", 1)
    kept.in_force("in-force", 2)
    yield kept
    kept.store.close()


def test_measured_recording_goes_and_its_row_and_the_log_say_so(kept):
    kept.of_pass("p1")
    with capture_logs() as said:
        assert kept.tidy() == ["p1"]
    assert kept.left() == set()
    with kept.store.look() as session:
        row = the(session, Recording, "p1")
    assert (row.deleted_at, row.deleted_why) == (NOW, "older than keep_days = 1e-06")
    assert [(one["event"], one["recording"]) for one in said] == [("recording deleted", "p1")]
    assert kept.tidy() == []


@pytest.mark.parametrize(
    "state",
    [
        PassState.ARMED,
        PassState.RECORDING,
        PassState.RECORDED,
        PassState.MEASURING,
        PassState.FAILED,
    ],
)
def test_recording_of_a_pass_that_is_not_done_stays(kept, state):
    kept.of_pass("p1", state)
    assert kept.tidy() == []
    assert kept.left() == {"p1.mcap"}


def test_unmeasured_recording_of_a_pass_that_is_done_stays(kept):
    """One of its sensors had no calibration, or its measuring was refused."""
    kept.of_pass("p1", measured=False)
    kept.of_pass("p2", measured=False, calibration_id=None)
    assert kept.tidy() == []


def test_recording_measured_with_another_calibration_only_stays(kept):
    kept.of_pass("p1", measured=False)
    kept.add(
        Measurement(
            recording_id="p1", frame=1, calibration_id="old", sensor="left", pass_id="p1",
            reference="S1002", software="none", measured_at=NOW, wheel={},
        )
    )  # fmt: skip
    assert kept.tidy() == []


def test_session_goes_once_a_calibration_came_of_it_and_none_in_force_did(kept):
    for name in ("unused", "used", "in-force", "laser-off", "solving", "failed"):
        kept.of_session(f"s-{name}")
    kept.calibration("c1", "s-used")
    kept.calibration("c2", "s-in-force", laser_off=["s-laser-off"])
    kept.calibration("c3", "s-solving", state=CalibrationState.SOLVING)
    kept.calibration("c4", "s-failed", state=CalibrationState.FAILED)
    kept.in_force("c2", 3)
    assert kept.tidy() == ["s-used"]
    kept.in_force("c1", 4)
    assert kept.tidy() == ["s-in-force", "s-laser-off"]


def test_oldest_measured_go_until_the_quota_is_kept(kept):
    for name in ("p1", "p2", "p3"):
        kept.of_pass(name, measured=name != "p1")
    kept.recording("other", pass_id=None)
    size = (kept.root / "recordings" / "p1.mcap").stat().st_size
    quota = StorageSettings(quota_gb=3.5 * size / 1e9)
    assert kept.tidy(quota, free_of=lambda _: 10**12) == ["p2"]


def test_files_that_a_recording_went_on_in_go_with_it(kept):
    kept.of_pass("p1")
    path = kept.root / "recordings" / "p1.mcap"
    path.unlink()
    flat = np.zeros((48, 64), np.uint8)
    writer = RotatingWriter(path, "left", rotation=Rotation(size_bytes=1))
    for number in range(1, 4):
        writer.write_frame(number, number, number, flat.data.cast("B"), 64, 48)
        writer._wait_for_closing()
    writer.finish({})
    assert len(kept.left()) == 3
    assert kept.tidy() == ["p1"]
    assert kept.left() == set()


def test_interrupted_deletion_is_noted_the_next_time(kept):
    kept.of_pass("p1")
    (kept.root / "recordings" / "p1.mcap").unlink()
    assert kept.tidy() == ["p1"]


def test_calibration_that_came_into_force_meanwhile_keeps_its_recording(kept, monkeypatch):
    import station.storage.tidying as tidying  # noqa: PLC0415  beside its only use

    kept.of_session("s1")
    kept.calibration("c1", "s1")
    chosen = tidying.to_delete

    def slow(*arguments):
        kept.in_force("c1", 3)
        return chosen(*arguments)

    monkeypatch.setattr(tidying, "to_delete", slow)
    kept.tidy()
    assert kept.left() == {"s1.mcap"}


def test_measured_recordings_are_to_be_compacted_and_no_others(kept):
    kept.of_pass("p1")
    kept.of_pass("p2", measured=False)
    kept.of_session("s1")
    kept.calibration("c1", "s1")
    assert due_for_compacting(kept.store, NOW) == ["p1"]
    assert due_for_compacting(kept.store, NOW - timedelta(days=365)) == []
    done = compact_recording(kept.store, kept.root, "p1", NOW)
    assert [report.path.name for report in done.compacted] == ["p1.mcap"]
    assert is_compact(kept.root / "recordings" / "p1.mcap")
    assert len(list(frames(kept.root / "recordings" / "p1.mcap"))) == 2
    assert due_for_compacting(kept.store, NOW) == []
    again = compact_recording(kept.store, kept.root, "p1", NOW)
    assert (again.compacted, again.left) == ((), ())


def test_damaged_recording_stays_and_says_why(kept):
    kept.of_pass("p1")
    (kept.root / "recordings" / "p1.mcap").write_bytes(b"no recording")
    done = compact_recording(kept.store, kept.root, "p1", NOW)
    assert "not MCAP" in done.left[0]


def test_recording_for_which_there_is_no_space_is_left_for_later(kept, monkeypatch):
    import station.storage.compacting as compacting  # noqa: PLC0415  beside its only use

    def refuse(_path):
        raise DiskFull("no space")

    kept.of_pass("p1")
    monkeypatch.setattr(compacting, "compact", refuse)
    with pytest.raises(DiskFull):
        compact_recording(kept.store, kept.root, "p1", NOW)
    assert due_for_compacting(kept.store, NOW) == ["p1"]


def test_failed_pass_goes_by_its_own_limit_and_by_no_other(kept):
    kept.of_pass("p1", PassState.FAILED)
    kept.of_pass("p2", PassState.FAILED)
    kept.of_pass("p3")
    assert kept.tidy(StorageSettings(keep_failed_days=98.5)) == ["p1"]
    assert kept.tidy(StorageSettings(quota_gb=1e-9)) == ["p3"]
    assert kept.left() == {"p2.mcap"}


def test_unfinished_file_is_never_among_those_that_go(tmp_path):
    with RecordingWriter(tmp_path / "a.mcap"):
        assert files_of_recording(tmp_path / "a.mcap") == []


def test_uploads_go_by_their_own_age_alone_and_not_while_something_needs_them(kept):
    for name in ("older", "needed", "younger"):
        kept.recording(name, sha256=name)
    kept.calibration("from-upload", "needed")
    kept.in_force("from-upload", 3)
    assert kept.tidy(StorageSettings(keep_days=1.0, keep_failed_days=1.0)) == []
    assert kept.tidy(StorageSettings(keep_uploads_days=97.5)) == ["older"]
    with kept.store.look() as session:
        assert the(session, Recording, "older").deleted_why == (
            "uploaded; older than keep_uploads_days = 97.5"
        )
    assert kept.left() == {"needed.mcap", "younger.mcap"}
    assert kept.tidy(StorageSettings(keep_uploads_days=1.0)) == ["younger"]
