"""Profile files become rows of results, beside what their headers say."""

import json

import pytest
from profile_files import miniprof_file

from measure import Alarm, Limit, Limits, Quantity, Status
from station.documents import MeasurementDocument
from station.errors import InputUnusable
from station.pipeline import gauge_files, read_profile

HEADER = {"Sh": "29.0", "Sd": "32.5", "qR": "10.8", "WheelID": "4711"}


def test_a_file_is_a_wheel_with_its_own_figures_beside_ours(tmp_path):
    path = miniprof_file(tmp_path / "a.whl", HEADER, worn_mm=1.0)
    document = gauge_files([path])
    (wheel,) = document.wheels
    assert (wheel.source, wheel.reason, document.calibration) == ("a.whl", None, None)
    assert wheel.tread_wear.value == pytest.approx(1.0, abs=2e-3)
    assert wheel.header.claimed[Quantity.FLANGE_HEIGHT] == 29.0
    assert wheel.header.fields["WheelID"] == "4711"
    assert wheel.header.levels_mm == {"L1": 2.0, "L2": 70.0, "L3": 10.0}
    said = json.loads(document.model_dump_json())["wheels"][0]["header"]["claimed"]
    assert said == {"flange_height": 29.0, "flange_thickness_10": 32.5, "flange_gradient_qr": 10.8}


def test_a_profile_says_how_its_wear_is_spread(tmp_path):
    (wheel,) = gauge_files([miniprof_file(tmp_path / "a.whl", worn_mm=1.0)]).wheels
    wear = dict(zip(wheel.profile.d_mm, wheel.profile.wear_mm, strict=True))
    assert all(lost is None for d, lost in wear.items() if d < 14.0)
    # Rounded to 0.1 um in the file, laid on a tip read to 1 um.
    assert all(lost == pytest.approx(1.0, abs=2e-3) for d, lost in wear.items() if d > 61.0)


def test_a_part_of_a_wheel_gives_what_it_shows_among_the_others(tmp_path):
    whole = miniprof_file(tmp_path / "whole.whl")
    part = miniprof_file(tmp_path / "part.whl", from_d_mm=5.0)
    document = gauge_files([part, whole])
    assert document.wheels[0].flange_height.status is Status.REFERENCE_ASSUMED
    assert document.wheels[0].flange_thickness_10.status is Status.MISSING
    (half,) = gauge_files([miniprof_file(tmp_path / "half.whl", to_d_mm=60.0)]).wheels
    assert "half a wheel" in half.reason
    (assumed,) = gauge_files([part], assume_back=True).wheels
    assert assumed.flange_thickness_10.status is Status.REFERENCE_ASSUMED


def test_gauges_touch_where_the_header_says(tmp_path):
    path = miniprof_file(tmp_path / "a.whl", {"L2": "73.5", "L3": "14"})
    (wheel,) = gauge_files([path]).wheels
    assert wheel.header.levels_mm["L2"] == 73.5
    # The tread falls by 1 in 33 there; the face at +14 lies nearer to the back than at +12.
    assert wheel.flange_height.value > 28.05
    assert wheel.flange_thickness_10.value < wheel.flange_thickness_12.value


def test_limits_in_force_raise_the_alarms(tmp_path):
    path = miniprof_file(tmp_path / "a.whl", worn_mm=1.0)
    limits = Limits("ours", {Quantity.TREAD_WEAR: Limit(high_mm=0.9)})
    document = gauge_files([path], limits=limits)
    assert document.regime == "ours"
    assert document.wheels[0].tread_wear.alarm is Alarm.ALARM
    assert document.wheels[0].flange_height.alarm is Alarm.NONE


def test_results_of_files_come_back_as_they_were(tmp_path):
    document = gauge_files([miniprof_file(tmp_path / "a.whl", HEADER)])
    document.write(tmp_path / "r.json")
    assert MeasurementDocument.read(tmp_path / "r.json") == document


@pytest.mark.parametrize("coding", ["utf-8-sig", "latin-1", "utf-16"])
def test_letters_of_any_country_are_no_obstacle(tmp_path, coding):
    path = miniprof_file(tmp_path / "a.whl")
    path.write_bytes(("Line=K\u00f6ln\n" + path.read_text()).encode(coding))
    assert read_profile(path).header["Line"] == "K\u00f6ln"


@pytest.mark.parametrize(
    ("content", "match"),
    [
        (b"", "no rows"),
        (b"\x89PNG\r\n\x1a\n" + bytes(range(256)) * 20, "x.whl: "),
        (b"Sd=32.5\n\n1 2\n", "1 rows"),
        (b"d,h\n" + b"\n".join(b"%d,%d" % (i, i % 2) for i in range(100)), "no flange"),
    ],
)
def test_what_is_no_wheel_is_refused_in_one_line(tmp_path, content, match):
    path = tmp_path / "x.whl"
    path.write_bytes(content)
    with pytest.raises(InputUnusable, match=match) as refusal:
        gauge_files([path])
    assert "\n" not in str(refusal.value)
    with pytest.raises(InputUnusable, match="cannot be read"):
        gauge_files([tmp_path / "absent.whl"])
    with pytest.raises(InputUnusable, match="no PROFILE"):
        gauge_files([])
