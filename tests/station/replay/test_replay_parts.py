"""What was measured is not measured again, and every recording stands once among the parts."""

import json
from pathlib import Path

import fsspec
import numpy as np
import pytest
from wheel_recordings import FILE_FOR_EACH_FRAME, record, true_calibration, views_of

import station.replay.work as replay_work
from station.cli.main import build_app, run
from station.errors import InputUnusable
from station.replay import Means, Replay, replay_recordings
from station.replay.forms import Form
from station.replay.parts import PartFolder
from station.replay.task import RecordingFiles, ReplayTask, Token
from station.scenes import WheelTruth

CALIBRATION = true_calibration()
MEANS = "f" * 64


def recording(name, state="as it is"):
    return RecordingFiles(name, (name,), Token.of(name, [name], [state]), frames=1)


def task(*names, state="as it is"):
    return ReplayTask(tuple(recording(name, state) for name in names))


def kept(folder):
    return sorted(path.name.partition(".")[0] for path in folder.iterdir())


@pytest.fixture
def parts(tmp_path):
    return PartFolder(tmp_path / "parts", Form.ROWS, MEANS)


CONTENT = Form.ROWS.encoded(None, [])


def put(parts, given):
    return parts.put(given.name, given.tokens, CONTENT)


def test_a_part_is_found_again_by_another_run(parts):
    put(parts, task("a.mcap"))
    again = PartFolder(parts.folder, Form.ROWS, MEANS)
    assert again.of(task("a.mcap")) is not None
    assert again.of(task("b.mcap")) is None


def test_a_part_of_other_means_or_form_is_left_where_it_is(parts):
    put(parts, task("a.mcap"))
    for form, means in ((Form.ROWS, "0" * 64), (Form.WHEELS, MEANS)):
        other = PartFolder(parts.folder, form, means)
        assert other.of(task("a.mcap")) is None
        put(other, task("a.mcap"))
    assert len(list(parts.folder.iterdir())) == 3


def test_a_recording_that_has_changed_is_measured_again_in_place_of_its_part(parts):
    old = put(parts, task("a.mcap"))
    changed = task("a.mcap", state="longer")
    assert parts.of(changed) is None
    new = put(parts, changed)
    assert list(parts.folder.iterdir()) == [new.path]
    assert new.path != old.path


def test_the_part_of_a_whole_pass_takes_the_place_of_one_with_less_of_it(parts):
    put(parts, task("left.mcap"))
    put(parts, task("left.mcap", "right.mcap"))
    assert kept(parts.folder) == ["left"]
    assert parts.of(task("right.mcap")) is not None


def test_a_part_with_other_recordings_beside_is_not_replaced_by_less(parts):
    put(parts, task("left.mcap", "right.mcap"))
    with pytest.raises(Exception, match="replay all recordings of the pass") as refused:
        put(parts, task("left.mcap", state="longer"))
    assert "\n" not in str(refused.value)
    assert len(list(parts.folder.iterdir())) == 1


def test_a_part_that_is_cut_short_does_not_count(parts):
    part = put(parts, task("a.mcap"))
    part.path.write_bytes(CONTENT[:-3])
    assert PartFolder(parts.folder, Form.ROWS, MEANS).of(task("a.mcap")) is None


def test_a_pass_of_many_sensors_has_a_name_that_a_disk_takes(parts):
    many = task(*(f"{'very-' * 20}long{number}.mcap" for number in range(10)))
    put(parts, many)
    assert PartFolder(parts.folder, Form.ROWS, MEANS).of(many) is not None


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return a folder with two recordings of one wheel each, the second in two files."""
    folder = tmp_path_factory.mktemp("archive")
    rng = np.random.default_rng(5)
    views = views_of(WheelTruth(tread_wear_mm=1.0), (-20.0, 0.0), rng, seed=1)
    (folder / "monday").mkdir()
    record(folder / "monday" / "left.mcap", [views])
    record(folder / "left.mcap", [views], rotation=FILE_FOR_EACH_FRAME)
    return folder


@pytest.fixture
def counted(monkeypatch):
    """Count the tasks that are measured."""
    names = []
    measured = replay_work.Doing.do
    monkeypatch.setattr(
        replay_work.Doing, "do", lambda self, task: names.append(task.name) or measured(self, task)
    )
    return names


def test_a_replay_that_was_killed_goes_on_where_it_was(folder, tmp_path, counted):
    whole = replay_recordings([folder], CALIBRATION, tmp_path / "whole.csv")
    assert (whole.recordings, whole.found_measured, len(counted)) == (2, 0, 2)

    class KilledError(BaseException):
        pass

    def kill(done, what):
        if what.startswith("1 of"):
            raise KilledError

    out = tmp_path / "killed.csv"
    with pytest.raises(KilledError):
        replay_recordings([folder], CALIBRATION, out, progress=kill)
    assert not out.exists()
    counted.clear()
    report = replay_recordings([folder], CALIBRATION, out)
    assert len(counted) == 1
    assert (report.recordings, report.found_measured, report.wheels) == (2, 1, 2)
    assert out.read_bytes() == whole.out.read_bytes()
    assert not (tmp_path / "killed.csv.parts").exists()


def test_a_folder_takes_a_table_of_each_recording_and_a_second_run_reads_nothing(
    folder, tmp_path, counted
):
    out = tmp_path / "results"
    first = replay_recordings([folder], CALIBRATION, out)
    before = {path: path.read_bytes() for path in out.iterdir()}
    assert [path.suffix for path in before] == [".parquet"] * 2
    counted.clear()
    second = replay_recordings([folder], CALIBRATION, out)
    assert counted == []
    assert (first.wheels, first.measured) == (second.wheels, second.measured) == (2, 2)
    assert (second.found_measured, second.frames) == (2, 0)
    assert {path: path.read_bytes() for path in out.iterdir()} == before


def test_a_dry_run_tells_what_there_is_to_do_and_writes_nothing(folder, tmp_path):
    out = tmp_path / "results"
    forecast = Replay([folder], Means.of([CALIBRATION]), out).forecast()
    assert (forecast.recordings, forecast.tasks, forecast.found_measured) == (2, 2, 0)
    assert forecast.frames == 4
    assert not out.exists()


def test_what_lies_at_a_url_reads_the_same_as_what_lies_here(folder, tmp_path):
    far = fsspec.filesystem("memory")
    far.put(str(folder), f"/{folder.name}", recursive=True)
    try:
        here = replay_recordings([folder], CALIBRATION, tmp_path / "here.csv")
        there = replay_recordings([f"memory://{folder.name}"], CALIBRATION, tmp_path / "there.csv")
        assert (there.recordings, there.frames, there.refused) == (2, 4, ())
        assert there.out.read_bytes() == here.out.read_bytes()
        with pytest.raises(InputUnusable, match="no recording"):
            replay_recordings(["memory://nowhere"], CALIBRATION, tmp_path / "no.csv")
    finally:
        far.rm(f"/{folder.name}", recursive=True)


@pytest.mark.parametrize(
    ("url", "message"),
    [
        ("memory://gone/left.mcap", "not there"),
        ("pigeon://left.mcap", "cannot be read .*pigeon"),
        ("s3://bucket/left.mcap", r"pip install treadline\[s3\]"),
    ],
)
def test_a_url_that_cannot_be_read_is_one_line(tmp_path, url, message):
    with pytest.raises(InputUnusable, match=message) as refused:
        replay_recordings([url], CALIBRATION, tmp_path / "r.csv")
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("out", ["s3://archive/results.parquet", "gs://archive/results"])
def test_a_table_at_a_url_is_refused_in_one_line_that_names_it(folder, out):
    with pytest.raises(InputUnusable, match=f"--out {out}: not supported, .* give a path"):
        replay_recordings([folder], CALIBRATION, Path(out))


def test_a_folder_without_a_recording_is_refused(tmp_path):
    with pytest.raises(InputUnusable, match="no recording"):
        replay_recordings([tmp_path], CALIBRATION, tmp_path / "r.csv")


def test_workers_make_the_same_table_to_the_last_byte(folder, tmp_path, workers):
    here = replay_recordings([folder], CALIBRATION, tmp_path / "here.json").out
    means = Means.of([CALIBRATION])
    report = Replay([folder], means, tmp_path / "there.json").run_with(workers)
    assert (report.recordings, report.wheels, report.frames) == (2, 2, 4)
    made = [json.loads(path.read_bytes()) for path in (here, report.out)]
    assert made[0]["wheels"] == made[1]["wheels"]


def test_command_takes_a_cluster_and_a_reference_that_its_workers_do_not_have(
    folder, tmp_path, cluster, capsys
):
    CALIBRATION.write(tmp_path / "calibration.json")
    profile = tmp_path / "worn.csv"
    rows = (f"{d},{-0.05 * abs(d - 70.0)}" for d in range(5, 131))
    profile.write_text("\n".join(["d_mm,h_mm", *rows]))
    arguments = [str(folder), f"--calibration={tmp_path / 'calibration.json'}", "--json"]
    out = tmp_path / "results"
    assert run(build_app("replay"), ["replay", *arguments, f"--out={out}", "--dry-run"]) == 0
    assert json.loads(capsys.readouterr().out)["tasks"] == 2
    command = ["replay", *arguments, f"--out={out}", f"--cluster={cluster}"]
    assert run(build_app("replay"), command) == 0
    assert json.loads(capsys.readouterr().out)["measured"] == 2
    assert run(build_app("replay"), [*command, "--workers=2"]) == 2
    assert "give one of them" in capsys.readouterr().err
