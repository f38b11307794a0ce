"""The demo station holds what the pages are to show, and all of it was recorded and measured.

That its figures are as good as they can be is shown elsewhere: its cameras are small, so that it
is soon made.
"""

import csv
import hashlib
import json
import sqlite3

import numpy as np
import pytest
from demo_station_browser import Complaints, ensure_accessible
from demo_station_quiet import LIVE_PICTURES, LIVE_SESSION
from demo_station_story import (
    DARK_WHEEL,
    LOST_FRAME,
    MARKUP,
    PASSES,
    SCRIPT,
    UNSEEN_TRAIN,
)
from demo_station_truth import FIRST_LIGHTS, LEVELS, RIG, RIGHT, wheel_at

from station.client import CallRefused
from station.recording import EventKind, events, verify
from station.settings import load_settings

TREAD_WEAR = "tread_wear"


@pytest.fixture(scope="module")
def look(demo_data):
    """Ask the station's store, read only."""
    file = demo_data.folder / "data" / "station.sqlite"
    connection = sqlite3.connect(f"file:{file}?mode=ro", uri=True)
    yield lambda query: connection.execute(query).fetchall()
    connection.close()


@pytest.fixture(scope="module")
def quiet(quiet_demo):
    with quiet_demo.client() as client:
        yield client


def wear_of_train(client, pass_id):
    """Return tread wear, true tread wear and alarm of each wheel of a weekly train."""
    rows = {row["id"]: row["wheel"] for row in client.wheels(pass_id)}
    level = PASSES.index(pass_id)
    for axle in client.train(pass_id)["axles"]:
        for side in ("left", "right"):
            wheel = rows[axle[side]["measurement"]]
            truth = wheel_at(level + axle["number"] - 1, side).readings.tread_wear
            yield wheel[TREAD_WEAR], truth


@pytest.mark.parametrize("pass_id", [PASSES[0], LOST_FRAME, PASSES[-1]])
def test_wheels_read_what_was_rendered(quiet, pass_id):
    found = list(wear_of_train(quiet, pass_id))
    assert len(found) == 8
    for reading, truth in found:
        assert reading["value"] == pytest.approx(truth, abs=max(2.0 * reading["u95"], 0.05))


def test_wear_grows_to_a_warning_and_an_alarm(quiet):
    by_pass = [[reading for reading, _ in wear_of_train(quiet, name)] for name in PASSES]
    values = [[reading["value"] for reading in wheels] for wheels in by_pass]
    assert (np.diff(np.array(values), axis=0) > 0.5).all()
    assert {reading["alarm"] for reading in by_pass[0]} == {"none"}
    assert {reading["alarm"] for reading in by_pass[-1]} == {"none", "warning", "alarm"}


def test_axles_have_their_back_to_back_distance(quiet):
    distances = [axle["back_to_back"]["value"] for axle in quiet.train(PASSES[0])["axles"]]
    assert distances == pytest.approx([1360.0] * 4, abs=0.5)


def test_a_wheel_that_nobody_can_measure_is_a_row_with_its_reason(quiet):
    wheels = quiet.wheels(DARK_WHEEL)
    (unmeasured,) = [row for row in wheels if row["wheel"]["reason"]]
    assert unmeasured["sensor"] == RIGHT
    assert "no stripe" in unmeasured["wheel"]["reason"]
    assert len(wheels) == 12


def test_a_train_that_no_camera_saw_has_failed_and_says_why(look):
    (row,) = look(f"SELECT state, reason FROM passes WHERE id = '{UNSEEN_TRAIN}'")
    assert row[0] == "failed"
    assert "no frame was recorded" in row[1]


def test_lost_frames_are_accounted_for_in_store_and_file(demo_data, look):
    rows = look(f"SELECT path, lost, complete FROM recordings WHERE pass_id = '{LOST_FRAME}'")
    assert sorted(lost for _, lost, _ in rows) == [0, 1, 1]
    for path, lost, complete in rows:
        told = [event.kind for event in events(demo_data.folder / "data" / path)]
        gaps = {EventKind.FRAMES_LOST, EventKind.FRAMES_MISCOUNTED} & set(told)
        assert bool(gaps) == bool(lost) == (not complete)


def test_all_recordings_are_sound_files_on_the_disk(demo_data, look):
    paths = [path for (path,) in look("SELECT path FROM recordings WHERE recorded > 0")]
    assert len(paths) > 25
    assert all(verify(demo_data.folder / "data" / path).ok for path in paths[::6])


def test_the_right_sensor_has_a_history_of_calibrations(look):
    states = look(f"SELECT state, passed FROM calibrations WHERE sensor = '{RIGHT}'")
    assert states.count(("failed", None)) == 1
    assert len([state for state, _ in states if state == "ready"]) >= 3
    by = {who for (who,) in look(f"SELECT activated_by FROM activations WHERE sensor = '{RIGHT}'")}
    assert len(by) == 3
    assert look(f"SELECT count(*) FROM rig_activations WHERE rig = '{RIG}'") == [(1,)]


def test_a_calibration_has_its_points_used_and_doubtful(demo_data, quiet):
    points = quiet.calibration_points(demo_data.told.calibrations["right-preplanar"])
    rows = list(csv.DictReader(points.splitlines()))
    assert {row["kind"] for row in rows} == {"dot", "stripe"}
    assert {row["used"] for row in rows} == {"0", "1"}
    assert {"saturated", "glare", "stray light"} <= {row["reason"] for row in rows}
    assert len({row["image"] for row in rows}) == len(FIRST_LIGHTS)


def test_the_pictures_of_a_calibration_are_on_the_disk(demo_data, look):
    name = demo_data.told.calibrations["right-1"]
    ((document,),) = look(f"SELECT document FROM calibrations WHERE id = '{name}'")
    (source,) = json.loads(document)["inputs"]
    ((path,),) = look("SELECT path FROM recordings WHERE session_id = 'right-first'")
    recording = (demo_data.folder / "data" / path).read_bytes()
    assert hashlib.sha256(recording).hexdigest() == source["sha256"]


def test_nights_ended_in_every_way(look):
    states = {state for (state,) in look("SELECT state FROM recalibrations")}
    assert states == {"kept", "activated", "refused", "asking"}
    ((answer,),) = look("SELECT answer FROM recalibrations WHERE state = 'refused'")
    assert SCRIPT in answer


def test_a_replay_stands_beside_the_readings_of_the_pass(demo_data, look):
    rows = look(
        "SELECT m.calibration_id, count(*) FROM measurements m WHERE "
        f"m.recording_id = 'pass.{PASSES[4]}.{RIGHT}' GROUP BY m.calibration_id"
    )
    assert dict(rows)[demo_data.told.calibrations["right-1"]] == 4
    assert [count for _, count in rows] == [4, 4]


def test_jobs_ended_in_every_way_and_none_is_left(look):
    assert {state for (state,) in look("SELECT state FROM jobs")} == {"done", "failed", "cancelled"}


def test_texts_of_people_are_kept_as_they_were_typed(look):
    trains = {train for (train,) in look("SELECT train FROM passes")}
    assert {MARKUP, SCRIPT} <= trains


@pytest.mark.parametrize("scope", ["read", "operate", "calibrate", "admin"])
def test_a_key_of_each_scope_opens_what_it_may(quiet_demo, scope):
    with quiet_demo.client(scope) as client:
        assert client.train(PASSES[0])["axles"]
        if scope == "read":
            with pytest.raises(CallRefused):
                client.arm_pass("not-mine")


def test_a_calibration_session_is_open_with_its_pictures(quiet_demo):
    session = quiet_demo.ask(f"/v1/calibration-sessions/{LIVE_SESSION}").json()
    assert (session["state"], session["pictures"]) == ("open", LIVE_PICTURES)


def test_a_copy_leaves_what_it_was_made_of_alone(demo_data, tmp_path):
    copy = demo_data.copy_to(tmp_path)
    recording = next(copy.rglob("*.mcap"))
    recording.unlink()
    (copy / "station.sqlite").write_bytes(b"")
    source = demo_data.folder / "data"
    assert (source / recording.relative_to(copy)).stat().st_size > 0
    assert (source / "station.sqlite").stat().st_size > 0


def test_its_settings_file_is_one_of_a_station(demo_data):
    settings = load_settings(demo_data.folder / "station.toml")
    assert [sensor.id for sensor in settings.sensors][-1] == RIGHT
    assert settings.track is not None


def test_a_train_passes_live_and_is_measured(served_demo):
    served_demo.pass_live("live-1", axles=4)
    with served_demo.client("read") as client:
        found = [row["wheel"][TREAD_WEAR]["value"] for row in client.wheels("live-1")]
    assert len(found) == 8
    assert max(found) < wheel_at(LEVELS, "left").tread_wear_mm


def test_a_target_is_shown_live_and_a_session_takes_it(served_demo):
    served_demo.show_target("right-live", pictures=6)
    assert served_demo.ask("/v1/calibration-sessions/right-live").json()["pictures"] == 6
    with served_demo.client("calibrate") as client:
        client.finish_calibration_session("right-live")


def complaints_of(chromium, url, expected=()):
    context = chromium.new_context(locale="en-US")
    page, complaints = context.new_page(), Complaints(list(expected))
    complaints.listen(page)
    page.goto(url)
    page.evaluate("() => console.error('a fault')")
    with page.expect_event("pageerror"):
        page.evaluate("() => { setTimeout(() => { throw new Error('uncaught fault') }, 0) }")
    context.close()
    return complaints


def test_console_errors_uncaught_ones_and_refusals_are_complaints(chromium, quiet_demo):
    heard = "\n".join(complaints_of(chromium, f"{quiet_demo.url}/static/nowhere").unexpected)
    assert "console: a fault" in heard
    assert "uncaught: uncaught fault" in heard
    assert "response: 40" in heard


def test_complaints_that_a_test_declares_are_none(chromium, quiet_demo):
    expected = ["a fault", "uncaught", "nowhere", "favicon"]
    assert not complaints_of(chromium, f"{quiet_demo.url}/static/nowhere", expected).unexpected


def test_a_person_logs_in_with_a_key(page, logged_in, served_demo):
    assert logged_in(page, "operate").url.startswith(f"{served_demo.url}/now")


def test_a_picture_that_says_nothing_to_the_blind_is_a_fault(page):
    page.set_content(
        '<html lang="en"><title>t</title><main><h1>h</h1><img src="data:,"></main></html>'
    )
    with pytest.raises(AssertionError, match="image-alt"):
        ensure_accessible(page)
