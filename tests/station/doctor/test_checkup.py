"""Shows that the host is examined by another process, once at a time, and that what hangs or fails
there is told.  What the checks say is shown elsewhere."""

import subprocess
import threading
from datetime import UTC, datetime, timedelta

import pytest

from station.doctor import Checkup, Finding, Patient, examine_apart
from station.doctor.demand import Stream
from station.doctor.examining import main, patient_as_text, patient_of_text
from station.errors import NothingMeasurable, StateConflict
from station.settings import StorageSettings

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)
FINE = Finding("disk speed", "900 MB/s")
PATIENCE_S = 30.0


class Clock:
    def __init__(self):
        self.now = NOON

    def __call__(self):
        self.now += timedelta(seconds=1)
        return self.now


def ended(checkup):
    done = threading.Event()
    for _ in range(int(PATIENCE_S / 0.01)):
        if checkup.began_at is None:
            return checkup.last
        done.wait(0.01)
    raise AssertionError("the examination did not end")


def test_an_examination_is_begun_and_later_there_with_its_time():
    checkup = Checkup(lambda: [FINE], Clock())
    assert checkup.last is None
    checkup.begin()
    last = ended(checkup)
    assert (last.findings, last.problem) == ([FINE], None)
    assert NOON < last.began_at < last.ended_at


def test_while_one_goes_on_there_is_no_other():
    go_on = threading.Event()
    checkup = Checkup(lambda: [FINE] * go_on.wait(PATIENCE_S), Clock())
    checkup.begin()
    assert checkup.began_at is not None
    with pytest.raises(StateConflict, match="examined already"):
        checkup.begin()
    go_on.set()
    assert ended(checkup).findings == [FINE]
    checkup.begin()
    ended(checkup)


def test_one_that_fails_is_told_and_does_not_stand_in_the_way():
    def fail():
        raise NothingMeasurable("no folder to write to")

    checkup = Checkup(fail, Clock())
    checkup.begin()
    assert ended(checkup).problem == "no folder to write to"
    checkup.begin()
    ended(checkup)


def test_a_patient_goes_to_another_process_and_is_the_same_there(tmp_path):
    stream = Stream("left", "127.47.2.1", packet_size=1500, frame_rate_hz=10.0, ring_slots=4)
    patient = Patient(tmp_path, (stream,), StorageSettings(quota_gb=5.0))
    assert patient_of_text(patient_as_text(patient)) == patient


def answering(monkeypatch, **done):
    def run(command, **_):
        return subprocess.CompletedProcess(command, 0, **done)

    monkeypatch.setattr(subprocess, "run", run)


def test_the_process_prints_what_it_found_and_that_is_read(monkeypatch, capsys, tmp_path):
    found = [FINE, Finding("clock", "not kept", "apt-get install chrony")]
    monkeypatch.setattr("station.doctor.examining.examine", lambda _: found)
    monkeypatch.setattr("station.doctor.examining.os.nice", lambda _: None)
    monkeypatch.setattr("sys.stdin.read", lambda: patient_as_text(Patient(tmp_path)), raising=False)
    main()
    answering(monkeypatch, stdout=capsys.readouterr().out)
    assert examine_apart(Patient(tmp_path)) == found


def test_a_process_that_dies_hangs_or_refuses_is_told_in_words(monkeypatch, tmp_path):
    def die(command, **_):
        raise subprocess.CalledProcessError(-9, command)

    def hang(command, **_):
        raise subprocess.TimeoutExpired(command, 180.0)

    for run, told in ((die, "ended without an answer"), (hang, "did not end within 180 s")):
        monkeypatch.setattr(subprocess, "run", run)
        with pytest.raises(NothingMeasurable, match=told):
            examine_apart(Patient(tmp_path))
    answering(monkeypatch, stdout='{"refused": "no folder"}')
    with pytest.raises(NothingMeasurable, match="no folder"):
        examine_apart(Patient(tmp_path))
    answering(monkeypatch, stdout="half a docu")
    with pytest.raises(NothingMeasurable, match="without an answer"):
        examine_apart(Patient(tmp_path))


def test_a_real_process_examines_the_host(tmp_path):
    patient = Patient(tmp_path / "not" / "there", (), StorageSettings())
    (tmp_path / "not").touch()
    with pytest.raises(NothingMeasurable, match="not a folder"):
        examine_apart(patient)
