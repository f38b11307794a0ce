"""Shows what two sensors that look at one wheel say of it together, from their recordings."""

from dataclasses import replace

import numpy as np
import pytest
from rig_recordings import (
    INNER,
    OUTER,
    RIG_WHEEL,
    calibration_of,
    record_rig,
    true_rig,
)

from station.cli.main import build_app, run
from station.documents import MeasurementDocument
from station.errors import InputUnusable, RecordingUnreadable
from station.pipeline import RigGauge, measure_rig, measure_train
from station.recording import info

NEEDS_BOTH = ("flange_height", "flange_thickness_10", "tread_wear")


@pytest.fixture(scope="module")
def folder(tmp_path_factory, rig_shots):
    """Two wheels, the first in two shots; the outer sensor missed the second wheel."""
    folder = tmp_path_factory.mktemp("rig")
    record_rig(folder, [rig_shots, rig_shots[:1]], lost=[(OUTER, 3)])
    true_rig().write(folder / "rig.json")
    return folder


@pytest.fixture(scope="module")
def measured(folder):
    return measure_rig(files(folder), true_rig())


def files(folder, sensors=(INNER, OUTER)):
    return {name: folder / f"{name}.mcap" for name in sensors}


def test_both_sensors_measure_a_wheel_together_and_the_row_says_which_gave_what(measured):
    wheel, _ = measured.wheels
    assert wheel.reason is None
    assert (wheel.sensor, wheel.sensors) == ("wheel", (INNER, OUTER))
    assert (wheel.source, wheel.frames) == ("inner.mcap", (1, 2))
    truth = RIG_WHEEL.readings
    for name in NEEDS_BOTH:
        reading = wheel.readings[name]
        # One wheel: three of the standard deviations that it tells itself, u95 / 1.96.
        sigma = reading.u95 / 1.96
        assert reading.value == pytest.approx(getattr(truth, name), abs=3.0 * sigma)
        assert reading.status == "ok"
    assert measured.rigs == {"wheel": true_rig().fingerprint}
    assert measured.calibration_of(wheel) == true_rig().fingerprint
    assert measured.calibrations == true_rig().calibrations


def test_the_profile_tells_which_sensor_saw_which_part(measured):
    profile = measured.wheels[0].profile
    assert profile.sensors == (INNER, OUTER)
    d = np.array(profile.d_mm)
    seen = [profile.seen_by_names(point) for point in range(len(d))]
    # No camera on the field side sees round the flange to its back.
    assert {names for place, names in zip(d, seen, strict=True) if place < 1.0} == {(INNER,)}
    assert set(seen) == {(INNER,), (OUTER,), (INNER, OUTER)}


def test_a_diameter_that_the_sheets_do_not_tell_is_missing_and_the_row_says_why(measured):
    for wheel in measured.wheels:
        assert wheel.diameter.value is None
        assert "one sheet tells where the axle is" in wheel.quality["diameter"]["reason"]


def test_where_one_sensor_missed_the_wheel_the_other_says_what_it_can_and_invents_nothing(measured):
    wheel = measured.wheels[1]
    assert wheel.sensors == (INNER,)
    share = wheel.quality["by_sensor"][OUTER]
    assert share["points"] == 0
    assert share["reason"]
    reading = wheel.flange_thickness_10
    assert reading.value is None or reading.u95 >= measured.wheels[0].flange_thickness_10.u95


def test_a_sensor_without_a_recording_is_said_in_each_row(folder):
    document = measure_rig(files(folder, [INNER]), true_rig())
    assert [wheel.frames for wheel in document.wheels] == [(1, 2), (3,)]
    for wheel in document.wheels:
        assert wheel.quality["by_sensor"][OUTER]["reason"] == "no recording"


def test_a_newer_calibration_takes_the_place_of_the_rigs_own_and_the_row_says_so(folder):
    newer = calibration_of(OUTER).model_copy(update={"method": "deviation"})
    document = measure_rig(files(folder), true_rig(), calibrations=[newer, calibration_of(INNER)])
    assert document.calibrations[OUTER] == newer.fingerprint
    assert {tuple(wheel.quality["recalibrated"]) for wheel in document.wheels} == {(OUTER,)}


def test_frames_that_no_trigger_joins_are_no_shot(folder):
    # The cameras' times are 0.3 ms apart: a bound of 0.1 ms takes each frame for a shot.
    document = measure_rig(files(folder), true_rig(), max_skew_us=100.0)
    assert len(document.wheels[0].frames) == 4


def test_a_damaged_recording_is_refused_or_left_to_the_other(folder, tmp_path):
    whole, broken = folder / "inner.mcap", tmp_path / "outer.mcap"
    content = bytearray((folder / "outer.mcap").read_bytes())
    middle = len(content) // 2
    content[middle : middle + 64] = bytes(64)
    broken.write_bytes(content)
    sources = {INNER: whole, OUTER: broken}
    with pytest.raises(RecordingUnreadable, match=r"outer\.mcap"):
        measure_rig(sources, true_rig())
    document = measure_rig(sources, true_rig(), all_sound=False)
    assert [wheel.sensors for wheel in document.wheels] == [(INNER,), (INNER,)]
    assert "outer.mcap" in document.wheels[0].quality["by_sensor"][OUTER]["reason"]


def test_a_rig_and_its_gauge_say_the_same_in_another_process(folder):
    gauge = replace(
        RigGauge.of(true_rig(), "S1002", calibrations=[calibration_of(INNER)]),
        silent={OUTER: "asleep"},
    )
    make, given = gauge.__reduce__()
    again = make(*given)
    assert (again.silent, again.rig_id) == (gauge.silent, gauge.rig_id)
    assert info(folder / "inner.mcap").sensors[0].sensor in again.rig.names


def test_recordings_and_pictures_do_not_pair(folder, tmp_path):
    (tmp_path / "1.png").touch()
    with pytest.raises(InputUnusable, match="give recordings of all sensors, or pictures of all"):
        measure_rig({INNER: folder / "inner.mcap", OUTER: tmp_path}, true_rig())


def test_as_many_pictures_of_each_sensor_are_wanted(tmp_path):
    for name, count in ((INNER, 2), (OUTER, 1)):
        (tmp_path / name).mkdir()
        for place in range(count):
            (tmp_path / name / f"{place}.png").touch()
    with pytest.raises(InputUnusable, match="there are of inner 2, outer 1; give as many of each"):
        measure_rig({name: tmp_path / name for name in (INNER, OUTER)}, true_rig())


def test_a_rig_that_stands_nowhere_measures_nothing(folder):
    with pytest.raises(InputUnusable, match="cannot measure wheels"):
        measure_rig(files(folder), true_rig(survey=None))


def test_wheels_of_a_rig_stand_on_the_axles_of_the_train(folder):
    document = measure_train([*files(folder).values()], [], rigs=[true_rig()], sides={}, counted=2)
    assert [(wheel.axle, wheel.side, wheel.sensor) for wheel in document.wheels] == [
        (1, "left", "wheel"),
        (2, "left", "wheel"),
    ]
    assert document.rigs == {"wheel": true_rig().fingerprint}


def test_the_command_measures_on_a_rig_and_writes_the_row(folder, tmp_path, capsys):
    out = tmp_path / "results.json"
    sources = [str(path) for path in files(folder).values()]
    command = ["measure", *sources, f"--rig={folder / 'rig.json'}", f"--out={out}"]
    assert run(build_app("measure"), command) == 0
    assert capsys.readouterr().out.startswith("inner.mcap frame ")
    first = MeasurementDocument.read(out).wheels[0]
    assert (first.sensor, first.sensors) == ("wheel", (INNER, OUTER))
    assert run(build_app("measure"), ["measure", *sources]) == 2
    assert "give --calibration of the sensor, or --rig" in capsys.readouterr().err
