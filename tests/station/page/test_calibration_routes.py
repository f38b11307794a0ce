"""The page of calibrations over HTTP: who may decide, what is refused, what is told to scripts."""

import re
from contextlib import contextmanager

import httpx
import pytest
from demo_station_quiet import LIVE_PICTURES, LIVE_SESSION
from demo_station_serving import served_quietly
from demo_station_truth import INNER, OUTER, RIGHT

MARKUP = "<img src=x onerror=alert(1)>"


@pytest.fixture(scope="module")
def own(demo_data, tmp_path_factory):
    """A station of these tests alone: they decide on its calibrations."""
    with served_quietly(demo_data, tmp_path_factory.mktemp("calibration")) as demo:
        yield demo


@contextmanager
def called(demo, scope):
    headers = {"Authorization": f"Bearer {demo.keys[scope]}"}
    with httpx.Client(base_url=demo.url, headers=headers, timeout=60.0, trust_env=False) as client:
        yield client


@pytest.fixture(scope="module")
def reader(own):
    with called(own, "read") as client:
        yield client


@pytest.fixture(scope="module")
def calibrator(own):
    with called(own, "calibrate") as client:
        yield client


@pytest.fixture(scope="module")
def calibrations(own):
    return own.data.told.calibrations


def in_force(reader):
    return reader.get(f"/v1/sensors/{RIGHT}/active-calibration").raise_for_status()


@pytest.mark.parametrize(
    "address",
    [
        "/calibration",
        "/calibration/state",
        "/calibration/made",
        f"/calibration/sensors/{RIGHT}",
        f"/calibration/sessions/{LIVE_SESSION}",
        "/calibrations/{right-1}",
        "/rig-calibrations/{rig}",
        "/calibrations/{right-1}/solving",
        "/rig-calibrations/{rig}/solving",
    ],
)
def test_who_reads_sees_the_page_and_no_button_that_decides(reader, calibrations, address):
    text = reader.get(address.format(**calibrations)).raise_for_status().text
    posted = re.findall(r'hx-post="([^"]+)"', text)
    assert set(posted) <= {"/logout"}


def test_figures_and_points_of_a_report_are_told(reader, calibrations):
    address = f"/calibrations/{calibrations['right-1']}"
    figures = reader.get(f"{address}/figures").raise_for_status().json()
    picture = reader.get(f"{address}/pictures/0").raise_for_status().json()
    assert picture["name"] == figures["pictures"][0]["name"]
    assert figures["comparison"]["rms_mm"] > 0.0  # something else is in force by now
    frame = picture["frame"]
    shown = f"/v1/recordings/{frame['recording']}/frames/{frame['number']}/picture?max_width=320"
    assert reader.get(shown).raise_for_status().content.startswith(b"\x89PNG")
    assert reader.get(f"{address}/pictures/999").status_code == 404


def test_shifts_of_readings_are_told_and_none_of_what_is_in_force(reader, calibrations):
    told = (
        reader.get(f"/v1/calibrations/{calibrations['right-1']}/shifts").raise_for_status().json()
    )
    assert {each["quantity"] for each in told["shifts"]} >= {"flange_height", "flange_thickness_10"}
    assert told["within"] == all(each["within"] for each in told["shifts"])
    assert told["reason"] is None
    wheel = reader.get(f"/v1/measurements/{told['measurement']}").raise_for_status().json()
    stated = {each["quantity"]: each["reading_u95_mm"] for each in told["shifts"]}
    assert stated["flange_height"] == wheel["wheel"]["flange_height"]["u95"]
    present = reader.get(f"/v1/calibrations/{told['against']}/shifts").raise_for_status().json()
    assert (present["against"], present["shifts"], present["within"]) == (None, [], None)
    assert "nothing else is in force" in present["reason"]


def test_each_sensor_of_a_rig_has_its_figures_and_its_points(reader, calibrations):
    address = f"/rig-calibrations/{calibrations['rig']}"
    for sensor in (INNER, OUTER):
        figures = reader.get(f"{address}/sensors/{sensor}/figures").raise_for_status().json()
        picture = reader.get(f"{address}/sensors/{sensor}/pictures/0").raise_for_status().json()
        assert picture["name"] == figures["pictures"][0]["name"]
        assert picture["frame"]["recording"].endswith(sensor)
        points = reader.get(f"/v1{address}/points/{sensor}").raise_for_status().text
        assert points.startswith("image,kind,row,col,u,v")
        assert picture["name"] in points
    assert reader.get(f"{address}/sensors/{INNER}/pictures/999").status_code == 404
    assert reader.get(f"{address}/sensors/{RIGHT}/figures").status_code == 404
    assert f"/sensors/{OUTER}/figures" in reader.get(address).text


def test_what_failed_has_its_reason_and_no_figures(reader):
    rows = reader.get("/v1/calibrations", params={"sensor": RIGHT}).json()["calibrations"]
    failed = next(row for row in rows if row["state"] == "failed")
    assert "at least 3" in reader.get(f"/calibrations/{failed['id']}").text
    answer = reader.get(f"/calibrations/{failed['id']}/figures")
    assert answer.status_code == 409
    assert answer.json()["state"] == "failed"


def test_the_printable_report_is_one_page_without_scripts(reader, calibrations):
    answer = reader.get(f"/calibrations/{calibrations['right-1']}/report").raise_for_status()
    assert "<title>Calibration of" in answer.text
    assert "data:image/jpeg" in answer.text
    assert "script-src" not in answer.headers["content-security-policy"]
    assert "default-src 'none'" in answer.headers["content-security-policy"]


def test_guidance_tells_every_picture_and_the_next_pose(reader):
    told = reader.get(f"/calibration/sessions/{LIVE_SESSION}/guidance").raise_for_status().json()
    (sensor,) = told["sensors"]
    assert told["state"] == "open"
    assert [pose["number"] for pose in sensor["poses"]] == list(range(1, LIVE_PICTURES + 1))
    assert all(pose["dots"] > 0 for pose in sensor["poses"])
    assert sensor["next"]["falls_to"] < 1.0
    assert reader.get("/calibration/sessions/nothing/guidance").status_code == 404


@pytest.mark.parametrize(
    ("address", "form"),
    [
        ("/calibration/sessions", {"name": "a", "of": "sensor:right", "rows": 7, "cols": 8,
                                   "pitch_mm": 12}),
        (f"/calibration/sessions/{LIVE_SESSION}/capture", {}),
        (f"/calibration/sessions/{LIVE_SESSION}/finish", {}),
        (f"/calibration/sessions/{LIVE_SESSION}/solve", {"sensor": RIGHT}),
        ("/calibrations/demo000007/activate", {"seen": 1}),
        ("/calibrations/demo000007/refuse", {"why": "no"}),
        ("/rig-calibrations/demo000005/activate", {"seen": 1}),
        ("/rig-calibrations/demo000005/refuse", {"why": "no"}),
        ("/calibration/recalibrations/x/answer", {"action": "refuse", "why": "no", "seen": 1}),
    ],
)  # fmt: skip
def test_who_may_only_operate_changes_nothing(own, address, form):
    with called(own, "operate") as operator:
        assert operator.post(address, data=form).status_code == 403


def test_a_calibration_is_not_activated_over_one_that_the_person_has_not_seen(
    reader, calibrator, calibrations
):
    address = f"/calibrations/{calibrations['right-1']}/activate"
    before = in_force(reader).json()
    answer = calibrator.post(address, data={"seen": before["version"] - 1})
    assert answer.status_code == 412
    assert "somebody changed it" in answer.json()["detail"]
    assert in_force(reader).json() == before
    answer = calibrator.post(address, data={"seen": before["version"]})
    assert answer.status_code == 204
    assert answer.headers["hx-redirect"] == f"/calibrations/{calibrations['right-1']}"
    assert in_force(reader).json()["calibration"] == calibrations["right-1"]


def test_a_refused_calibration_keeps_the_reason_as_text_and_never_comes_into_force(
    reader, calibrator, calibrations
):
    name = calibrations["right-2"]
    assert calibrator.post(f"/calibrations/{name}/refuse", data={"why": MARKUP}).status_code == 204
    text = reader.get(f"/calibrations/{name}").text
    assert MARKUP not in text
    assert "&lt;img src=x onerror=alert(1)&gt;" in text
    version = in_force(reader).json()["version"]
    answer = calibrator.post(f"/calibrations/{name}/activate", data={"seen": version})
    assert answer.status_code == 409
    assert answer.json()["state"] == "refused"
    assert reader.get(f"/v1/calibrations/{name}").json()["refused_why"] == MARKUP


def test_what_is_in_force_cannot_be_refused(calibrator, calibrations):
    answer = calibrator.post(f"/rig-calibrations/{calibrations['rig']}/refuse", data={"why": "old"})
    assert answer.status_code == 409
    assert answer.json()["state"] == "active"


@pytest.mark.parametrize("why", ["", " \t"])
def test_a_refusal_without_a_reason_is_none(calibrator, calibrations, why):
    name = calibrations["left-inner"]
    answer = calibrator.post(f"/calibrations/{name}/refuse", data={"why": why})
    assert answer.status_code == 422


def test_a_target_that_there_is_not_is_refused_in_words(calibrator):
    form = {"name": "s1", "of": "sensor:right", "rows": 7, "cols": 8, "pitch_mm": 12,
            "diameter_mm": 20}  # fmt: skip
    answer = calibrator.post("/calibration/sessions", data=form)
    assert answer.status_code == 422
    assert "diameter" in answer.json()["detail"]


def test_a_session_is_taken_finished_and_solved(reader, calibrator):
    one = f"/calibration/sessions/{LIVE_SESSION}"
    answer = calibrator.post(f"{one}/capture")
    assert answer.status_code == 204
    assert '"pictures"' in answer.headers["hx-trigger"]
    assert calibrator.post(f"{one}/finish").status_code == 204
    assert "hx-post" not in reader.get(one).text.replace('hx-post="/logout"', "")
    answer = calibrator.post(f"{one}/solve", data={"sensor": RIGHT, "method": "joint"})
    assert answer.status_code == 204
    assert reader.get(answer.headers["hx-redirect"]).status_code == 200
    assert calibrator.post(f"{one}/capture").status_code == 409
