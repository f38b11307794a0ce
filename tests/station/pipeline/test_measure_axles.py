"""Shows the distance between flange backs from real recordings of both sides of a train."""

import csv
import json

import numpy as np
import pytest
from rig_recordings import (
    RIG_WHEEL,
    RIGHT,
    record_rig,
    shots_of,
    true_rig,
    true_right_rig,
)

from measure import Limit, Limits
from station.back_to_back import NO_TRACK
from station.cli.main import build_app, run
from station.documents import MeasurementDocument
from station.exports import table_writer
from station.pipeline import measure_train
from station.settings import TrackSettings

BETWEEN_MM, SIGMA_MM = 1500.0, 0.05
# Both wheels have their flange back 70 mm inside the tape circle; the right one stands 0.8 mm
# farther out.
TRUTH_MM = BETWEEN_MM - 140.0 + 0.8
TRACK = TrackSettings(distance_mm=BETWEEN_MM, sigma_distance_mm=SIGMA_MM, sigma_turn_rad=1e-4)


@pytest.fixture(scope="module")
def folder(tmp_path_factory, rig_shots):
    """Two axles in two shots each; the inner sensor on the right did not see the second."""
    folder = tmp_path_factory.mktemp("axles")
    rng = np.random.default_rng(5)
    right = shots_of(RIG_WHEEL, (-20.0, 10.0), rng, seed=9, truth=RIGHT, lateral_shift_mm=0.8)
    record_rig(folder, [rig_shots, rig_shots])
    names = RIGHT.exact.names
    inner = names[0]
    record_rig(folder, [right, right], sensors=names, lost=[(inner, 3), (inner, 4)])
    true_rig().write(folder / "left.json")
    true_right_rig().write(folder / "right.json")
    return folder


def measured(folder, **more):
    sources = sorted(folder.glob("*.mcap"))
    rigs = [true_rig(), true_right_rig()]
    return measure_train(sources, [], rigs=rigs, sides={}, counted=2, **more)


@pytest.fixture(scope="module")
def train(folder):
    return measured(folder, track=TRACK)


def test_an_axle_that_both_sides_saw_has_its_distance(train):
    first = train.axles[0]
    found = first.back_to_back
    assert (first.axle, first.placing) == (1, "certain")
    assert (found.status, found.pairs, found.alarm, found.reason) == ("ok", 2, "none", None)
    # Three standard deviations of those it tells itself; it cannot be surer than the frame is.
    assert found.value == pytest.approx(TRUTH_MM, abs=3.0 * found.u95 / 1.96)
    assert 1.96 * SIGMA_MM < found.u95 < 1.0


def test_a_flange_back_that_nobody_saw_makes_no_distance_and_the_axle_says_so(train):
    found = train.axles[1].back_to_back
    assert (found.value, found.status, found.alarm) == (None, "missing", "unknown")
    assert found.reason == (
        "the right wheel has no flange back that was seen by a sensor with a mounting"
    )


def test_a_distance_beyond_its_limit_is_an_alarm(folder):
    narrow = Limits("depot", {}, Limit(1357.0, 1359.0, warn_within_mm=0.0))
    document = measured(folder, track=TRACK, limits=narrow)
    assert [axle.back_to_back.alarm for axle in document.axles] == ["alarm", "unknown"]


def test_without_a_track_no_axle_has_one_and_that_is_said_once(folder):
    document = measured(folder)
    assert (document.axles, document.no_back_to_back) == ((), NO_TRACK)


def test_of_one_side_alone_nothing_is_said_of_axles(folder):
    own = [folder / "inner.mcap", folder / "outer.mcap"]
    document = measure_train(own, [], rigs=[true_rig()], sides={}, counted=2, track=TRACK)
    assert (document.axles, document.no_back_to_back) == ((), None)
    assert {"axles", "no_back_to_back"}.isdisjoint(json.loads(document.model_dump_json()))


def test_a_table_has_the_distance_in_the_rows_of_both_wheels(train, tmp_path):
    out = tmp_path / "wheels.csv"
    table_writer(out)(out, train, train.wheels)
    with out.open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    told = {(row["axle"], row["side"]): row["back_to_back"] for row in rows}
    assert told["1", "left"] == told["1", "right"] == str(train.axles[0].back_to_back.value)
    assert {row["back_to_back_status"] for row in rows if row["axle"] == "2"} == {"missing"}


def test_the_command_says_the_distance_and_writes_it(folder, tmp_path, capsys):
    config, out = tmp_path / "station.toml", tmp_path / "results.json"
    config.write_text(
        'data_dir = "."\n[[sensors]]\nid = "inner"\naddress = "192.168.1.2"\n'
        f"[track]\ndistance_mm = {BETWEEN_MM}\nsigma_distance_mm = {SIGMA_MM}\n"
        "sigma_turn_rad = 1e-4\n"
    )
    sources = [str(path) for path in sorted(folder.glob("*.mcap"))]
    rigs = [f"--rig={folder / name}.json" for name in ("left", "right")]
    command = ["measure", *sources, *rigs, "--axles=2", f"--config={config}", f"--out={out}"]
    assert run(build_app("measure"), command) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[-3].startswith("axle 1: back_to_back 136")
    assert lines[-2].startswith("axle 2: no back-to-back: the right wheel has no flange back")
    written = MeasurementDocument.read(out)
    assert written.axles[0].back_to_back.value == pytest.approx(TRUTH_MM, abs=0.5)
    kept = next(wheel for wheel in written.wheels if wheel.axle == 1)
    assert len(kept.standing.backs) == 2
