"""Recordings of rigs become the same table: a row a wheel, whichever sensors saw it."""

import json

import pytest
from rig_recordings import INNER, OUTER, record_rig, true_rig
from wheel_recordings import true_calibration

from station.cli.main import build_app, run
from station.documents import MeasurementDocument
from station.errors import InputUnusable
from station.replay import replay_recordings

RIG = true_rig()


@pytest.fixture(scope="module")
def passes(tmp_path_factory, rig_shots):
    """Two passes of one wheel each; of the second the outer sensor's recording is damaged."""
    folder = tmp_path_factory.mktemp("passes")
    found = {}
    for name in ("monday", "tuesday"):
        (folder / name).mkdir()
        found[name] = record_rig(folder / name, [rig_shots[:1]], session=name)
    broken = found["tuesday"][OUTER]
    content = bytearray(broken.read_bytes())
    middle = len(content) // 2
    content[middle : middle + 64] = bytes(64)
    broken.write_bytes(content)
    RIG.write(folder / "rig.json")
    return folder


def recordings(folder, *names):
    return [folder / name / f"{sensor}.mcap" for name in names for sensor in (INNER, OUTER)]


def test_recordings_of_a_pass_are_measured_on_its_rig_pass_for_pass(passes, tmp_path):
    out = tmp_path / "results.json"
    report = replay_recordings(recordings(passes, "tuesday", "monday")[::-1], [], out, rigs=[RIG])
    assert (report.recordings, report.wheels, report.measured) == (3, 2, 2)
    assert [refusal.recording for refusal in report.refused] == ["tuesday/outer.mcap"]
    document = MeasurementDocument.read(out)
    assert document.rigs == {"wheel": RIG.fingerprint}
    by_source = {wheel.source: wheel for wheel in document.wheels}
    monday, tuesday = (by_source[f"{name}/inner.mcap"] for name in ("monday", "tuesday"))
    assert monday.sensors == (INNER, OUTER)
    assert tuesday.sensors == (INNER,)
    # What is damaged is left out, and the row says why the other sensor is alone.
    assert "outer.mcap" in tuesday.quality["by_sensor"][OUTER]["reason"]
    assert {wheel.side for wheel in document.wheels} == {"left"}


def test_the_command_takes_rigs_beside_calibrations(passes, tmp_path, capsys):
    out = tmp_path / "results.csv"
    sources = [str(path) for path in recordings(passes, "monday")]
    command = ["replay", *sources, f"--rig={passes / 'rig.json'}", f"--out={out}", "--json"]
    assert run(build_app("replay"), command) == 0
    assert json.loads(capsys.readouterr().out)["measured"] == 1
    header, row = out.read_text().splitlines()
    told = dict(zip(header.split(","), row.split(","), strict=True))
    assert (told["sensor"], told["sensors"]) == ("wheel", "inner outer")
    assert told["calibration"] == RIG.fingerprint
    assert run(build_app("replay"), ["replay", *sources, f"--out={out}"]) == 2
    assert "give --calibration of the sensor, or --rig" in capsys.readouterr().err


def test_a_sensor_is_in_one_rig_alone(passes, tmp_path):
    other = true_rig(rig="again")
    with pytest.raises(InputUnusable, match="two rigs have a sensor in common"):
        replay_recordings(recordings(passes, "monday"), [], tmp_path / "r.json", rigs=[RIG, other])


def test_a_recording_of_no_rig_and_no_calibration_is_refused_and_named(passes, tmp_path):
    report = replay_recordings(
        recordings(passes, "monday"),
        [true_calibration(INNER), true_calibration("left")],
        tmp_path / "r.json",
    )
    (refusal,) = report.refused
    assert "outer.mcap is of sensor outer but the calibrations are of inner, left" in refusal.reason
