"""Shows how the settings file is read and refused."""

import numpy as np
import pytest

from measure import BACK_TO_BACK_TSI, PRESETS, Alarm, Limit, Limits, Quantity
from station.errors import InputUnusable
from station.limits import limits_of
from station.operations import DataLayout
from station.settings import MountingSettings, SensorSettings, load_settings

GOOD = """
data_dir = "data"
[[sensors]]
id = "left"
address = "192.168.1.2"
[sensors.mounting]
rotation_vector = [0, 0, 0]
translation_mm = [0, 0, 0]
[[sensors]]
id = "right"
address = "192.168.1.3"
"""


@pytest.fixture
def read(tmp_path, monkeypatch):
    monkeypatch.delenv("STATION_PORT", raising=False)
    path = tmp_path / "station.toml"

    def read_text(text):
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return load_settings(path)

    return read_text


def test_a_file_gives_typed_settings_with_defaults(read, tmp_path):
    settings = read(GOOD)
    assert settings.port == 8080
    assert settings.sensor("left").trigger == "Line1"
    assert settings.sensor("left").mounting.wheel_radius_mm == 420.0
    assert settings.sensor("middle") is None
    # A relative folder counts from the file, wherever the command is given.
    assert settings.data_dir == (tmp_path / "data").resolve()


def test_the_environment_wins_over_the_file_and_keys_in_it_are_no_settings(read, monkeypatch):
    monkeypatch.setenv("STATION_PORT", "9000")
    monkeypatch.setenv("STATION_ADMIN_KEY", "not a setting")
    assert read("port = 8000\n" + GOOD).port == 9000


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("prot = 80\n" + GOOD, "prot: Extra inputs are not permitted"),
        ("port = 70000\n" + GOOD, "port: Input should be less than or equal to 65535"),
        (GOOD.replace('"right"', '"left"'), "two sensors with the id 'left'"),
        (GOOD.replace("1.3", "1.2"), "two sensors with the address '192.168.1.2'"),
        (GOOD.replace('"left"', '"Left Side"'), "sensors.0.id: String should match"),
        ('data_dir = "data"\nsensors = []\n', "sensors: Tuple should have at least 1 item"),
        ("data_dir = \n", "not a TOML file"),
        (GOOD + "[limits.flange_hight]\nlow = 27\n", "no quantity 'flange_hight'; allowed: flange"),
        (GOOD + "[limits.tread_wear]\nhight = 8\n", "limits.tread_wear.hight: Extra inputs"),
        (GOOD + "[limits.tread_wear]\nhigh = inf\n", "limits.tread_wear.high: Input should be a"),
        (GOOD + "[limits.tread_wear]\njump = 0\n", "limits.tread_wear.jump: Input should be"),
        (
            GOOD + "[limits.flange_height]\nlow = 36\nhigh = 27\n",
            "low 36 and high 27 allow nothing",
        ),
        (GOOD + '[limits]\npreset = "uic"\n', "'practice', 'tsi' or 'china_freight'"),
        (
            GOOD + "[controller]\nquiet_s = 0\n",
            "controller.quiet_s: Input should be greater than 0",
        ),
        (GOOD + "[controller]\nquiet_s = nan\n", "controller.quiet_s: Input should be greater"),
        (
            GOOD + "[controller]\nquiet_s = 4000\n",
            "controller: Value error, quiet_s 4000 is more than pass_longest_s 1800, so no pass",
        ),
        (b"\xff\xfe", "not a TOML file"),
        ("", "data_dir: Field required"),
    ],
)
def test_a_wrong_setting_is_one_line_that_names_it(read, text, says):
    with pytest.raises(InputUnusable) as refusal:
        read(text)
    assert says in str(refusal.value)
    assert "station.toml" in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_sensor_that_mirrors_the_left_one_across_the_track_is_the_right_one(read):
    surveyed = GOOD.replace("translation_mm = [0, 0, 0]", "translation_mm = [-557, -118, -223]")
    assert read(surveyed).sensor("left").side == "right"
    told = surveyed.replace('id = "left"', 'id = "left"\nside = "left"')
    assert read(told).sensor("left").side == "left"
    mounting = MountingSettings(rotation_vector=(0, 0, 0), translation_mm=(-1, 0, 0))
    made = SensorSettings(id="a", address="127.0.0.2", mounting=mounting)
    assert (made.side, read(GOOD).sensor("right").side) == ("right", "left")


RIGS = """
data_dir = "data"
[[sensors]]
id = "outer"
address = "192.168.1.2"
[[sensors]]
id = "inner"
address = "192.168.1.3"
[sensors.mounting]
rotation_vector = [0, 0, 0]
translation_mm = [0, 0, 0]
[[sensors]]
id = "lone"
address = "192.168.1.4"
side = "right"
[[rigs]]
id = "wheel"
sensors = ["outer", "inner"]
"""


def test_a_rig_stands_where_its_first_surveyed_sensor_does_and_sees_what_its_sensors_see(read):
    settings = read(RIGS)
    rig = settings.rig("wheel")
    assert (settings.anchor_of(rig), settings.side_of(rig)) == ("inner", "left")
    told = read(RIGS + 'anchor = "outer"\nside = "left"\n')
    assert told.anchor_of(told.rig("wheel")) == "outer"


def test_a_sensor_in_no_rig_is_measured_by_itself(read):
    settings = read(RIGS)
    assert settings.rig_with("inner") is settings.rig("wheel")
    assert settings.rig_with("lone") is None
    assert read(GOOD).rigs == ()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (RIGS.replace('["outer", "inner"]', '["outer", "iner"]'), "the station has outer, inner"),
        (RIGS.replace('["outer", "inner"]', '["outer", "lone"]'), "but its sensor 'lone' of the"),
        (RIGS.replace('["outer", "inner"]', '["outer"]'), "rigs.0.sensors: Tuple should have at"),
        (RIGS.replace('["outer", "inner"]', '["outer", "outer"]'), "names sensor outer twice"),
        (RIGS + 'anchor = "lone"\n', "allowed: one of its sensors, outer, inner"),
        (RIGS + 'side = "right"\n', "is of the right side but its sensor 'outer' of the left"),
        (RIGS + "max_skew_us = 0\n", "rigs.0.max_skew_us: Input should be greater than 0"),
        (RIGS + "sigma_vibration_mm = 0\n", "rigs.0.sigma_vibration_mm: Input should be greater"),
        (RIGS.replace('"wheel"', '"lone"'), "rig 'lone': a sensor has that name"),
        (RIGS + RIGS[RIGS.index("[[rigs]]") :], "rig 'wheel': another rig has that name"),
        (
            RIGS + '[[rigs]]\nid = "again"\nsensors = ["inner", "outer"]\n',
            "sensor 'outer' is in two rigs",
        ),
    ],
)
def test_a_rig_that_does_not_fit_the_sensors_is_one_line_that_names_it(read, text, says):
    with pytest.raises(InputUnusable) as refusal:
        read(text)
    assert says in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_limits_are_those_of_practice_where_none_are_given(read):
    assert limits_of(read(GOOD).limits) == Limits.default()


def test_a_limit_given_takes_the_place_of_the_presets_and_the_name_says_so(read):
    given = GOOD + '[limits]\npreset = "tsi"\n[limits.tread_wear]\nhigh = 6\njump = 0.4\n'
    limits = limits_of(read(given).limits)
    assert limits.regime == "tsi, changed"
    assert limits.of[Quantity.TREAD_WEAR] == Limit(high_mm=6.0, jump_mm=0.4)
    untouched = PRESETS["tsi"].of[Quantity.FLANGE_HEIGHT]
    assert limits.of[Quantity.FLANGE_HEIGHT] == untouched
    named = read(given.replace("[limits]", '[limits]\nregime = "depot 7"')).limits
    assert limits_of(named).regime == "depot 7"


def test_the_store_is_a_file_unless_a_url_says_otherwise_and_no_print_shows_its_password(
    read, monkeypatch
):
    sensors = '[[sensors]]\nid = "left"\naddress = "127.0.0.2"\n'
    assert DataLayout.of(read(f'data_dir = "d"\n{sensors}')).store_url.endswith("station.sqlite")
    monkeypatch.setenv("STATION_STORE_URL", "postgresql://me:secret@host/station")
    settings = read(f'data_dir = "d"\n{sensors}')
    layout = DataLayout.of(settings)
    assert layout.store_url == "postgresql://me:secret@host/station"
    assert "secret" not in repr(settings) + repr(layout)


TRACK = "[track]\nsigma_distance_mm = 0.2\nsigma_turn_rad = 2e-4\n"


def test_a_track_by_one_distance_has_rigs_that_face_each_other(read):
    track = read(GOOD + TRACK + "distance_mm = 1500\n").track
    frame = track.frame()
    np.testing.assert_allclose(frame.right_from_left.translation_mm, [0.0, -1500.0, 0.0])
    np.testing.assert_allclose(np.sqrt(np.diag(frame.covariance)), [2e-4] * 3 + [0.0, 0.2, 0.0])
    assert (track.max_skew_us, track.fewest_pairs) == (5000.0, 2)
    assert read(GOOD).track is None


def test_a_track_by_a_whole_pose_is_that_pose(read):
    pose = "rotation_vector = [0, 0, 3.14159]\ntranslation_mm = [12, -1498.5, 3]\n"
    frame = read(GOOD + TRACK + pose).track.frame()
    np.testing.assert_allclose(frame.right_from_left.translation_mm, [12.0, -1498.5, 3.0])
    np.testing.assert_allclose(np.sqrt(np.diag(frame.covariance)), [2e-4] * 3 + [0.2] * 3)


@pytest.mark.parametrize(
    ("said", "says"),
    [
        ("", "give distance_mm, or rotation_vector and translation_mm"),
        ("translation_mm = [0, -1500, 0]\n", "give distance_mm, or rotation_vector and"),
        (
            "distance_mm = 1500\nrotation_vector = [0, 0, 3.14159]\ntranslation_mm = [0, 0, 0]\n",
            "the one or the other",
        ),
        ("distance_mm = 1.5\n", "track.distance_mm: Input should be greater than 500"),
        (
            "rotation_vector = [0, 0, 0]\ntranslation_mm = [0, -1500, 0]\n",
            "must turn rig y about",
        ),
        ("rotation_vector = [0, 0, 3.14159]\ntranslation_mm = [0, -inf, 0]\n", "finite"),
        ("distance_mm = 1500\nfewest_pairs = 0\n", "track.fewest_pairs: Input should be"),
    ],
)
def test_a_track_that_says_nothing_or_too_much_is_refused(read, said, says):
    with pytest.raises(InputUnusable) as refusal:
        read(GOOD + TRACK + said)
    assert says in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_limits_of_the_back_to_back_distance_are_the_regimes_or_those_given(read):
    of_practice = limits_of(read(GOOD).limits)
    assert of_practice.back_to_back == BACK_TO_BACK_TSI
    assert of_practice.judge_back_to_back(1356.9, 0.1) is Alarm.ALARM
    given = limits_of(read(GOOD + "[limits.back_to_back]\nlow = 1350\nhigh = 1356\n").limits)
    assert given.regime == "practice, changed"
    # Neither end is the worn one: only what the interval reaches over is a warning.
    alarms = [given.judge_back_to_back(value, 0.1) for value in (1350.2, 1355.8, 1355.95, 1356.1)]
    assert alarms == [Alarm.NONE, Alarm.NONE, Alarm.WARNING, Alarm.ALARM]
    nothing = limits_of(read(GOOD + '[limits]\npreset = "china_freight"\n').limits)
    assert nothing.judge_back_to_back(1300.0, 0.1) is Alarm.NONE


def test_a_missing_file_is_refused_with_what_to_give(tmp_path):
    with pytest.raises(InputUnusable, match=r"no such settings file; give one by --config"):
        load_settings(tmp_path / "none.toml")
