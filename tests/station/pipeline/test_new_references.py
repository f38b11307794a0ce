"""Measured new wheels become a file that every command takes as its reference."""

import hashlib
import json

import pytest
from profile_files import miniprof_file

from measure import Quantity
from station.documents import ReferenceDocument
from station.errors import InputUnusable
from station.pipeline import WheelGauge, gauge_files, load_reference, register_reference
from station.settings import load_settings


@pytest.fixture
def registered(tmp_path):
    """A reference of a wheel that stood 0.3 mm higher on its flange than drawn."""
    new = miniprof_file(tmp_path / "new.whl", {"WheelID": "W1"}, worn_mm=0.3)
    document = register_reference([new], "new wheel")
    document.write(tmp_path / "new.json")
    return tmp_path / "new.json"


def test_wear_is_counted_from_the_wheel_as_it_was_new(tmp_path, registered):
    later = miniprof_file(tmp_path / "later.whl", worn_mm=1.3)
    (by_drawing,) = gauge_files([later]).wheels
    document = gauge_files([later], reference=str(registered))
    (by_new,) = document.wheels
    assert document.reference == "new wheel"
    assert by_drawing.tread_wear.value == pytest.approx(1.3, abs=2e-3)
    for reading in (by_new.tread_wear, by_new.tread_wear_at_70):
        assert reading.value == pytest.approx(1.0, abs=2e-3)
    # Its own sigma is the floor of 2 um a point: tip and tread, each over 9 of them.
    assert by_new.tread_wear.u95 > by_drawing.tread_wear.u95
    assert by_new.flange_height == by_drawing.flange_height


def test_a_reference_says_where_it_came_from(tmp_path, registered):
    document = ReferenceDocument.read(registered)
    (origin,) = document.made_of
    digest = hashlib.sha256((tmp_path / "new.whl").read_bytes()).hexdigest()
    assert (origin.name, origin.sha256, origin.wheel) == ("new.whl", digest, "W1")
    assert document.options == {"step_mm": 0.25, "window_mm": 3.0}
    assert json.loads(registered.read_text())["format"] == "treadline-reference"


def test_several_measurements_are_averaged_and_their_spread_is_kept(tmp_path):
    worn = (0.2, 0.3, 0.4)
    files = [miniprof_file(tmp_path / f"{mm}.whl", worn_mm=mm) for mm in worn]
    nominal = register_reference(files, "mean").nominal[Quantity.FLANGE_HEIGHT]
    assert nominal.value == pytest.approx(28.3, abs=2e-3)
    assert nominal.spread == pytest.approx(0.1, abs=2e-3)
    # t(0.975, 2) x 0.1 / sqrt(3).
    assert nominal.u95 == pytest.approx(4.303 * 0.1 / 3**0.5, abs=5e-3)


def test_results_serve_as_well_as_profiles(tmp_path):
    path = miniprof_file(tmp_path / "a.whl", worn_mm=0.3)
    gauge_files([path]).write(tmp_path / "r.json")
    from_results = register_reference([tmp_path / "r.json"], "a")
    from_profile = register_reference([path], "a")
    for quantity, nominal in from_results.nominal.items():
        assert nominal.value == pytest.approx(from_profile.nominal[quantity].value, abs=1e-9)
    assert from_results.made_of[0].wheel == "a.whl"


def test_sensors_measure_by_it_and_hand_it_to_other_processes(registered, calibration):
    gauge = WheelGauge.of(calibration, str(registered))
    assert gauge.reference.name == "new wheel"
    again, arguments = gauge.__reduce__()
    assert again(*arguments).reference.height_sigma_mm == gauge.reference.height_sigma_mm > 0.0


@pytest.mark.parametrize("name", ["S1002", "", "a/b", "x" * 65, "two\nlines"])
def test_a_name_that_is_taken_or_unfit_is_refused(tmp_path, name):
    with pytest.raises(InputUnusable, match="--name"):
        register_reference([miniprof_file(tmp_path / "a.whl")], name)


def test_what_makes_no_reference_is_refused(tmp_path):
    part = miniprof_file(tmp_path / "part.whl", from_d_mm=5.0)
    with pytest.raises(InputUnusable, match="reference_assumed"):
        register_reference([part], "new")
    half = miniprof_file(tmp_path / "half.whl", to_d_mm=60.0)
    with pytest.raises(InputUnusable, match="half a wheel"):
        register_reference([half], "new")
    gauge_files([half]).write(tmp_path / "none.json")
    with pytest.raises(InputUnusable, match="none of its 1 wheels"):
        register_reference([tmp_path / "none.json"], "new")
    gauge_files([part], assume_back=True).write(tmp_path / "assumed.json")
    with pytest.raises(InputUnusable, match="reference_assumed"):
        register_reference([tmp_path / "assumed.json"], "new")
    files = [miniprof_file(tmp_path / f"{mm}.whl", worn_mm=mm) for mm in (0.0, 2.0)]
    with pytest.raises(InputUnusable, match="leave out what is worn"):
        register_reference(files, "new")


def changed(path, change):
    content = json.loads(path.read_text())
    change(content)
    path.write_text(json.dumps(content))
    return str(path)


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (lambda c: c["nominal"]["flange_height"].update(value=29.0), "stated 29"),
        (lambda c: c["nominal"].pop("flange_gradient_qr"), "lacks flange_gradient_qr"),
        (lambda c: c["profile"]["y_mm"].pop(), "equally long"),
        (lambda c: c.update(version=2), "version"),
        (lambda c: c["nominal"]["flange_height"].update(u95=-1.0), "greater than or equal to 0"),
    ],
    ids=["another height", "no gradient", "a point lost", "version", "u95"],
)
def test_a_file_that_was_tampered_with_is_refused(registered, change, match):
    with pytest.raises(InputUnusable, match=match) as refusal:
        load_reference(changed(registered, change))
    assert "\n" not in str(refusal.value)


def test_results_given_as_a_reference_are_told_from_one(tmp_path):
    gauge_files([miniprof_file(tmp_path / "a.whl")]).write(tmp_path / "r.json")
    with pytest.raises(InputUnusable, match="station reference register"):
        load_reference(str(tmp_path / "r.json"))


def test_a_profile_file_is_a_reference_as_it_is(tmp_path):
    reference = load_reference(str(miniprof_file(tmp_path / "table.whl", worn_mm=0.3)))
    assert reference.name == "table"
    # Chords of 0.3 mm over the tip's 12 mm lie 1 um low.
    assert reference.nominal[Quantity.FLANGE_HEIGHT] == pytest.approx(28.3, abs=2e-3)
    assert reference.height_sigma_mm == 0.0


def test_settings_name_a_reference_beside_them(tmp_path, registered):
    settings = tmp_path / "station.toml"
    sensor = '[[sensors]]\nid = "left"\naddress = "127.0.0.2"\n'
    settings.write_text(f'data_dir = "data"\nreference = "{registered.name}"\n{sensor}')
    assert load_reference(load_settings(settings).reference).name == "new wheel"
    settings.write_text(f'data_dir = "data"\nreference = "LMA"\n{sensor}')
    assert load_settings(settings).reference == "LMA"
