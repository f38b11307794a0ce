"""The pages of passes over HTTP, on the demo station: what they show is what the API tells."""

import html
import re

import httpx
import numpy as np
import pytest
from demo_station_story import DARK_WHEEL, LOST_FRAME, MARKUP, PASSES, SCRIPT

LIST_ROW = re.compile(r'<tr>\s*<th scope="row"><a id="pass-([^"]+)".*?</tr>', re.DOTALL)
LAST = PASSES[-1]


@pytest.fixture(scope="module")
def reader(quiet_demo):
    """A program with a key that may only read; the pages answer it as well."""
    key = {"Authorization": f"Bearer {quiet_demo.keys['read']}"}
    with httpx.Client(
        base_url=quiet_demo.url, headers=key, timeout=30.0, trust_env=False
    ) as client:
        yield client


def shown(reader, address, status=200):
    answer = reader.get(address)
    assert answer.status_code == status, answer.text
    return answer.text


def told(reader, address):
    return reader.get(address).raise_for_status().json()


def listed(text):
    return [row[1] for row in LIST_ROW.finditer(text)]


def wheel_of(reader, pass_id, number, side):
    axles = told(reader, f"/v1/passes/{pass_id}/wheels")["axles"]
    return axles[number - 1][side]["measurement"]


@pytest.mark.parametrize(
    ("search", "found"),
    [
        ({"id": "RB17"}, set(PASSES)),
        ({"train": "söhne"}, {PASSES[3]}),
        ({"train": SCRIPT}, {DARK_WHEEL}),
        ({"wheelset": "WS-1043"}, set(PASSES)),
        ({"state": "failed"}, {"shunting-3"}),
        ({"id": "nobody"}, set()),
        ({"from": "2000-01-01", "to": "2000-01-02"}, set()),
    ],
)
def test_the_search_finds_what_was_asked_for(reader, search, found):
    text = reader.get("/passes", params=search).raise_for_status().text
    assert set(listed(text)) == found
    assert ("No pass is as you search." in text) is not found


def test_the_list_alone_is_the_list_of_the_page(reader):
    page, part = shown(reader, "/passes?id=rb17"), shown(reader, "/pass-list?id=rb17")
    assert listed(part) == listed(page) == list(reversed(PASSES))
    assert "csrf" not in part


def test_the_list_says_how_many_alarms_each_train_raised(reader):
    rows = {row[1]: row[0] for row in LIST_ROW.finditer(shown(reader, "/passes"))}
    for name in PASSES:
        alarms = told(reader, f"/v1/passes/{name}/wheels")["alarms"]
        levels = [alarm["level"] for alarm in alarms]
        said = re.search(r"✕ (\d+) alarm", rows[name])
        assert (int(said[1]) if said else 0) == levels.count("alarm"), name
        said = re.search(r"! (\d+) warning", rows[name])
        assert (int(said[1]) if said else 0) == levels.count("warning"), name
        assert ("✓ nothing" in rows[name]) is (not levels), name
    assert "✓ nothing" not in rows["shunting-3"]
    assert "? 1 not measured" in rows[DARK_WHEEL]
    assert "2 lost" in rows[LOST_FRAME]


def test_days_that_run_backwards_are_refused_in_words(reader):
    answer = reader.get("/passes?from=2026-02-02&to=2026-02-01", headers={"Accept": "text/html"})
    assert answer.status_code == 422
    assert "the last day comes before the first" in answer.text


@pytest.mark.parametrize("view", ["row", "table"])
def test_a_train_shows_each_wheel_with_a_way_to_it(reader, view):
    text = shown(reader, f"/passes/{LAST}?view={view}")
    for axle in told(reader, f"/v1/passes/{LAST}/wheels")["axles"]:
        assert axle["wheelset"] in text
        for side in ("left", "right"):
            assert f'href="/wheels/{axle[side]["measurement"]}"' in text
    assert f"{told(reader, f'/v1/passes/{LAST}')['recordings'][0]['summary']}" in text


def test_what_somebody_called_a_train_is_text(reader):
    for pass_id, name in ((PASSES[3], MARKUP), (DARK_WHEEL, SCRIPT)):
        for address in ("/passes", f"/passes/{pass_id}", f"/passes/{pass_id}?view=table"):
            text = shown(reader, address)
            assert name not in text
            assert str(html.escape(name, quote=False)) in text.replace("&#34;", '"')


def test_a_pass_that_has_ended_is_not_asked_for_again(reader):
    assert "second from:body" not in shown(reader, f"/passes/{LAST}/train")


def test_a_lost_frame_and_an_unmeasured_wheel_are_said(reader):
    assert "7 frames of 8 triggered recorded, 1 lost" in shown(reader, f"/passes/{LOST_FRAME}")
    text = shown(reader, f"/passes/{DARK_WHEEL}")
    assert "Axle 3, right wheel: no stripe" in text


def test_a_wheel_shows_its_readings_by_what_it_was_measured_and_the_downloads(reader):
    wheel = wheel_of(reader, LAST, 4, "left")
    row = told(reader, f"/v1/measurements/{wheel}")
    text = shown(reader, f"/wheels/{wheel}")
    assert f"{row['wheel']['tread_wear']['value']:.3f}" in text
    assert "✕ beyond" in text
    assert f'href="/calibrations/{row["calibration"]}"' in text
    assert f'href="/rig-calibrations/{row["rig_calibration"]}"' in text
    for address in re.findall(r'href="(/v1/[^"]+)" download', text):
        answer = reader.get(html.unescape(address))
        assert answer.status_code == 200, address
        if "limit=1" in address and "csv" in address:
            assert answer.text.splitlines()[1].startswith(f"{wheel},")


def test_a_wheel_nobody_could_measure_says_why_and_has_no_drawing(reader):
    wheel = wheel_of(reader, DARK_WHEEL, 3, "right")
    assert "no stripe" in shown(reader, f"/wheels/{wheel}")
    assert "no profile" in shown(reader, f"/wheels/{wheel}/drawing", 404)


def test_a_wheel_seen_by_two_sensors_says_which_saw_what(reader):
    drawing = told(reader, f"/wheels/{wheel_of(reader, LAST, 1, 'left')}/drawing")
    assert drawing["sensors"] == ["left-inner", "left-outer"]
    seen = {tuple(strand["seen_by"]) for strand in drawing["strands"]}
    assert seen == {(0,), (1,), (0, 1)}
    profile = told(reader, f"/v1/measurements/{drawing['measurement']}")["wheel"]["profile"]
    for place, name_at in enumerate(drawing["names_at"]):
        nearest = np.hypot(
            np.subtract(profile["d_mm"], name_at[0]), np.subtract(profile["h_mm"], name_at[1])
        ).argmin()
        assert profile["seen_by"][nearest] == 1 << place


def test_the_frames_of_a_wheel_are_those_of_its_sensors(reader):
    wheel = wheel_of(reader, LAST, 1, "left")
    row, text = told(reader, f"/v1/measurements/{wheel}"), shown(reader, f"/wheels/{wheel}/source")
    places = re.findall(r'data-stripe="(/v1/recordings/([^/]+)/frames/\d+)/stripe"', text)
    assert {recording for _, recording in places} == {
        f"pass.{LAST}.left-inner",
        f"pass.{LAST}.left-outer",
    }
    for place, recording in places:
        frames = told(reader, f"/v1/recordings/{recording}/frames")["frames"]
        number = int(place.rsplit("/", 1)[1])
        assert frames[number - 1]["frame"] == row["frame"]


def test_a_frame_that_one_sensor_lost_is_said(reader):
    texts = [
        shown(reader, f"/wheels/{each['id']}/source")
        for each in told(reader, f"/v1/passes/{LOST_FRAME}/wheels")["wheels"]
    ]
    # What was lost behind it shifts the places of the frames: they are found by their own number.
    later = [
        (int(frame), int(number))
        for text in texts
        for frame, number in re.findall(r"frame (\d+), picture (\d+) of [^<]*left-outer", text)
    ]
    assert any(number == frame - 1 for frame, number in later)


def test_a_trend_has_the_passes_of_the_wheelset(reader):
    chart = told(reader, "/wheelsets/WS-1043/trend/tread_wear")
    assert len(chart["x"]) == len(PASSES)
    left = next(each for each in chart["series"] if each["label"] == "Left")
    assert left["values"] == sorted(left["values"])
    assert any("other calibration" in moment["label"] for moment in chart["moments"])
    assert reader.get("/wheelsets/nobody/trend/tread_wear").status_code == 404


@pytest.mark.parametrize("address", ["/passes/nobody", "/wheels/999999", "/wheels/999999/source"])
def test_what_is_not_there_is_said(reader, address):
    assert "the station knows no such one" in shown(reader, address, 404)
