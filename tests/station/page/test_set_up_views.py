"""Shows what the parts of the set-up are made of: settings, cameras, limits, nights, keys."""

import os
from datetime import UTC, datetime, timedelta
from itertools import groupby

import pytest

from measure import Limit, Limits, Quantity
from station.capture import CaptureState, CaptureStatus
from station.limits import limits_of
from station.operations import DataLayout
from station.page.set_up.key_views import key_views
from station.page.set_up.limit_views import limit_views
from station.page.set_up.night_views import night_view
from station.page.set_up.sensor_views import sensor_views
from station.page.set_up.storage_views import last_backup
from station.page.set_up.told import settings_in, told
from station.page.texts import Texts
from station.recalibration import Outcome
from station.settings import (
    GateSettings,
    LimitsSettings,
    MountingSettings,
    PolicySettings,
    RegionSettings,
    SensorSettings,
    StationSettings,
    StorageSettings,
)
from station.store import Action, Key, Recalibration, RecalibrationState
from station.store.callers import Caller, Scope

NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)
TEXTS = Texts.of()


def a_station(tmp_path, **sensor):
    given = {"id": "left", "address": "127.47.1.1", **sensor}
    return StationSettings(data_dir=tmp_path, sensors=(given,))


def view_of(settings, **camera):
    status = CaptureStatus(CaptureState.IDLE, "left", camera=camera)
    (view,) = sensor_views(settings, {"left": status})
    return {each.setting.name: each for each in view.settings}


@pytest.mark.parametrize(
    ("name", "value", "shown"),
    [
        ("exposure_us", 12.5, "12.5\u202fµs"),
        ("translation_mm", (1.0, -2.0), "1, -2\u202fmm"),
        ("rotation_vector", (0.5,), "0.5\u202frad"),
        ("packet_size", 9000, "9000\u202fB"),
        ("measure_again", False, "false"),
        ("quota_gb", None, None),
    ],
)
def test_a_setting_is_told_with_the_unit_of_its_name(name, value, shown):
    assert told(name, value) == shown


@pytest.mark.parametrize(
    "section",
    [
        SensorSettings,
        RegionSettings,
        MountingSettings,
        StorageSettings,
        GateSettings,
        PolicySettings,
    ],
)
def test_every_plain_setting_that_is_shown_has_its_words(section):
    apart = {
        "id",
        "side",
        "address",
        "calibration_exposures",
        "mounting",
        "region",
        "features",
        "outputs",
    }
    for name in section.model_fields.keys() - apart:
        assert f"set_up.setting.{name}" in TEXTS


def test_every_word_that_data_ask_for_is_there():
    asked = {
        "quantity": [*Quantity, "back_to_back"],
        "action": Action,
        "scope": Scope,
        "night": RecalibrationState,
        "outcome": Outcome,
    }
    for table, names in asked.items():
        assert {f"set_up.{table}.{name}" for name in names} <= {*TEXTS}


def test_a_camera_that_holds_something_else_differs(tmp_path):
    settings = a_station(tmp_path, exposure_us=500.0, region={"width_px": 1024})
    held = {"exposure_us": "1000.0", "width": "1024", "feature.TriggerSource": "Line1"}
    view = view_of(settings, **held)
    assert (view["exposure_us"].held, view["exposure_us"].differs) == ("1000\u202fµs", True)
    assert not view["width_px"].differs
    assert not view["trigger"].differs


@pytest.mark.parametrize(
    ("wanted", "held", "differs"), [(500.0, "499.6", False), (500.0, "494.0", True)]
)
def test_what_a_camera_rounds_is_no_difference(tmp_path, wanted, held, differs):
    view = view_of(a_station(tmp_path, exposure_us=wanted), exposure_us=held)
    assert view["exposure_us"].differs == differs


def test_what_is_left_to_the_camera_never_differs(tmp_path):
    view = view_of(
        a_station(tmp_path, trigger="free"), gain_db="12.0", **{"feature.TriggerSource": "Line2"}
    )
    assert not view["gain_db"].differs
    assert view["gain_db"].setting.value is None
    assert not view["trigger"].differs


def test_a_feature_of_the_settings_is_compared_by_its_own_name(tmp_path):
    settings = a_station(tmp_path, features={"TestPattern": "Off"})
    assert view_of(settings, **{"feature.TestPattern": "Grey"})["TestPattern"].differs
    assert not view_of(settings, **{"feature.TestPattern": "off"})["TestPattern"].differs


def test_a_sensor_that_is_away_is_shown_by_its_settings_alone(tmp_path):
    (view,) = sensor_views(a_station(tmp_path, exposure_us=500.0), {})
    assert (view.state, view.identity, view.differing) == (None, {}, 0)
    assert all(each.held is None for each in view.settings)


def test_the_limits_say_which_the_file_gives():
    settings = LimitsSettings(tread_wear={"high": 6.0, "warn_within": 0.8})
    views = {view.name: view for view in limit_views(limits_of(settings), settings)}
    assert [name for name, view in views.items() if view.from_file] == ["tread_wear"]
    wear = views["tread_wear"]
    assert (wear.low_mm, wear.high_mm, wear.warns_from_mm) == (None, 6.0, pytest.approx(5.2))
    assert list(views)[-1] == "back_to_back"
    assert views["back_to_back"].jump_mm is None


@pytest.mark.parametrize(
    ("quantity", "limit", "kinds"),
    [
        (Quantity.TREAD_WEAR, Limit(high_mm=8.0), ["good", "warn", "bad"]),
        (Quantity.FLANGE_GRADIENT_QR, Limit(low_mm=6.5), ["bad", "warn", "good"]),
        (Quantity.FLANGE_HEIGHT, Limit(27.5, 36.0), ["bad", "good", "warn", "bad"]),
        (Quantity.FLANGE_THICKNESS_10, Limit(22.0, 33.0), ["bad", "warn", "good", "bad"]),
        (Quantity.HOLLOW_DEPTH, Limit(high_mm=2.0, warn_within_mm=0.0), ["good", "bad"]),
        (Quantity.FLANGE_HEIGHT, Limit(27.5, 36.0, 99.0), ["bad", "warn", "bad"]),
        (Quantity.DIAMETER, Limit(), []),
    ],
)
def test_a_band_goes_from_end_to_end_with_the_warning_at_the_worn_one(quantity, limit, kinds):
    (view,) = limit_views(Limits("regime", {quantity: limit}), LimitsSettings())
    merged = [kind for kind, _ in groupby(one.kind for one in view.band)]
    assert merged == kinds
    if kinds:
        ends = [one.start + one.length for one in view.band]
        assert [one.start for one in view.band[1:]] == pytest.approx(ends[:-1])
        assert (view.band[0].start, ends[-1]) == (0.0, pytest.approx(100.0))


def test_the_kinds_of_a_band_are_what_a_reading_there_would_raise():
    limits = limits_of(LimitsSettings())
    for view in limit_views(limits, LimitsSettings()):
        if view.low_mm is None or view.high_mm is None or view.name == "back_to_back":
            continue
        inner = view.high_mm - view.low_mm
        start, scale = view.low_mm - 0.25 * inner, 1.5 * inner / 100.0
        for part in view.band:
            middle_mm = start + scale * (part.start + part.length / 2.0)
            raised = limits.judge(Quantity(view.name), middle_mm, 0.0)
            assert {"none": "good", "warning": "warn", "alarm": "bad"}[raised] == part.kind


def test_the_nightly_job_is_next_due_by_the_stations_zone(paged):
    nightly = {"at": "02:30:00", "zone": "Europe/Berlin", "days": ("mon",)}
    settings = paged.settings.model_copy(
        update={"recalibration": type(paged.settings.recalibration)(**nightly)}
    )
    with paged.store.look() as session:
        view = night_view(session, settings, NOON)
    assert view.next_due == datetime(2026, 7, 6, 0, 30, tzinfo=UTC)
    with paged.store.look() as session:
        assert night_view(session, paged.settings, NOON).next_due is None


def test_the_nights_of_all_sensors_are_told_the_newest_first(paged):
    def row(name, sensor, hours, **told_of):
        at = NOON + timedelta(hours=hours)
        return Recalibration(
            id=name, sensor=sensor, ordered_at=at, job_id=name, findings={}, version=1, **told_of
        )

    with paged.store.change() as session:
        session.add(
            row(
                "a",
                "left",
                0,
                state=RecalibrationState.KEPT,
                ordered_by="schedule",
                due_at=NOON,
                outcome="consistent",
                reasons={"reasons": ["within"]},
            )
        )
        session.add(
            row(
                "b",
                "right",
                1,
                state=RecalibrationState.FAILED,
                ordered_by="I. Curie",
                reason="the worker died",
            )
        )
        session.add(row("c", "left", 2, state=RecalibrationState.RUNNING, ordered_by="I. Curie"))
    with paged.store.look() as session:
        view = night_view(session, paged.settings, NOON)
    assert [(night.id, night.by, night.reasons) for night in view.nights] == [
        ("c", "I. Curie", []),
        ("b", "I. Curie", ["the worker died"]),
        ("a", None, ["within"]),
    ]
    assert view.running == {"left"}


def test_keys_that_are_good_come_first_and_say_how_they_stand():
    def key(key_id, **times):
        given = {"expires_at": None, "revoked_at": None, "last_used_at": None, **times}
        return Key(
            id=key_id,
            name=key_id,
            scopes={"scopes": ["read"]},
            created_at=NOON,
            secret_sha256="",
            **given,
        )

    keys = [key("gone", revoked_at=NOON), key("good"), key("over", expires_at=NOON), key("mine")]
    caller = Caller("mine", frozenset({Scope.ADMIN}), key_id="mine")
    views = key_views(keys, at=NOON, caller=caller)
    assert [(view.id, view.standing, view.own) for view in views] == [
        ("mine", "good", True),
        ("good", "good", False),
        ("over", "expired", False),
        ("gone", "revoked", False),
    ]


def test_the_last_backup_is_told_by_its_name_and_its_time(tmp_path):
    layout = DataLayout(tmp_path)
    assert last_backup(layout) is None
    layout.backup_note.write_text("/mnt/nas/station-2026.backup\n")
    os.utime(layout.backup_note, (NOON.timestamp(), NOON.timestamp()))
    found = last_backup(layout)
    assert (found.file, found.at) == ("station-2026.backup", NOON)


def test_the_settings_of_a_section_know_their_place_in_the_file():
    found = settings_in(StorageSettings(quota_gb=5.0), "storage")
    assert ("storage.quota_gb", "5\u202fGB") in {(each.place, each.value) for each in found}
