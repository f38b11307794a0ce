"""The page says what the calibration says, safely and by itself. How it looks these do not show."""

import base64
import csv
import io
import re
import shutil

import cv2
import numpy as np
import pytest
from page_reading import everything, read_page
from report_samples import DOTS, HOSTILE, TARGET, WITHOUT_TARGET, by_hand, noise, save

from station.cli.main import build_app, run
from station.documents import Gate
from station.pictures import read_picture
from station.report import calibration_report

MINUS = "\N{MINUS SIGN}"


@pytest.fixture(scope="module")
def page(kept):
    return read_page(kept.page)


def rows_of(page, caption):
    (table,) = [t for t in page.all("table") if any(c.text == caption for c in t.all("caption"))]
    body = table.all("tbody")[0]
    return {row.children[0].text: [c.text for c in row.children[1:]] for row in body.all("tr")}


def agrees(shown, value):
    """Whether a printed number is the value, rounded to the digits that are printed."""
    text = shown.replace(MINUS, "-").split()[0]
    decimals = len(text.partition(".")[2])
    return float(text) == pytest.approx(value, abs=0.5001 * 10.0**-decimals)


def test_page_stands_by_itself(page):
    for element in everything(page):
        assert element.tag not in {"script", "link", "iframe", "object", "base"}
        for name, value in element.attributes.items():
            if name in {"href", "src", "xlink:href"}:
                assert value.startswith(("data:image/jpeg;base64,", "#"))
            assert not name.startswith("on")
            assert not re.search(r"url\((?!#)", value or "")
    style = page.all("style")[0].text
    assert not re.search(r"url\(|@import|https?:|//", style)


def test_every_mark_that_is_used_is_there(kept, page):
    there = {element.attributes.get("id") for element in everything(page)}
    used = set(re.findall(r"url\(#([^)]+)\)", kept.page))
    assert used
    assert used <= there


def test_texts_from_file_names_are_shown_and_never_obeyed(kept, page):
    assert HOSTILE in page.text
    assert WITHOUT_TARGET in page.text
    assert "<script" not in kept.page
    assert not page.all("b")
    assert all("data:" in img.attributes["src"] for img in page.all("img"))


def test_every_gate_is_shown_with_figure_and_limit(kept, page):
    gates = page.all("table")[0].all("tbody")[0].all("tr")
    for row, (name, gate) in zip(gates, kept.document.quality.items(), strict=True):
        state, demand, figure, limit, _bar = (cell.text for cell in row.children)
        assert state == ("passed" if gate.passed else "FAILED")
        assert name in demand
        assert agrees(figure, gate.value)
        assert agrees(limit.removeprefix("at most ").removeprefix("at least "), gate.limit)


def test_passed_gates_are_the_first_thing_said(kept):
    passing = {name: Gate(value=1.0, limit=2.0, passed=True) for name in ("one", "other")}
    document = kept.document.model_copy(update={"quality": passing})
    page = read_page(calibration_report(document, kept.points_csv))
    assert page.all("section")[0].all("p")[0].text == "Passed: all 2 gates."
    assert "FAILED" not in page.text


def test_failed_gate_is_the_first_thing_said(kept):
    gates = {
        "views_used": Gate(value=20.0, limit=3.0, passed=True),
        "glass_mm": Gate(value=0.2, limit=0.05, passed=False),
    }
    document = kept.document.model_copy(update={"quality": gates})
    page = read_page(calibration_report(document, kept.points_csv))
    assert page.all("section")[0].all("p")[0].text.startswith("Failed: 1 of 2 gates")
    row = page.all("table")[0].all("tr")[-1].text
    assert "FAILED" in row
    assert "at most 0.0500" in row


@pytest.mark.parametrize(
    ("gate", "side"),
    [
        (Gate(value=20.0, limit=3.0, passed=True), "at least 3"),
        (Gate(value=1.0, limit=3.0, passed=False), "at least 3"),
        (Gate(value=1.0, limit=3.0, passed=True), "at most 3"),
        (Gate(value=float("nan"), limit=3.0, passed=False), "at most 3"),
    ],
)
def test_side_of_a_limit_follows_from_what_passed(kept, gate, side):
    document = kept.document.model_copy(update={"quality": {"something_new": gate}})
    page = read_page(calibration_report(document, kept.points_csv))
    assert side in page.all("table")[0].text


def test_plane_and_camera_are_those_of_the_document(kept, page):
    plane = kept.document.plane
    shown = rows_of(page, "Light plane")
    variances = np.diag(np.array(kept.document.plane_covariance))
    for name, variance in zip("abcd", variances, strict=True):
        assert agrees(shown[name][0], getattr(plane, name))
        assert agrees(shown[name][1], np.sqrt(variance))
        assert agrees(shown[name][2], 1.96 * np.sqrt(variance))
    camera = rows_of(page, "Camera")
    for name in ("fx", "fy", "cx", "cy", "k1", "k2"):
        assert agrees(camera[name][0], getattr(kept.document.camera, name))
    held = set(camera) - set(kept.document.camera.estimated)
    assert {name for name, row in camera.items() if row[1] == "held"} == held


def test_every_input_is_named_with_its_hash(kept, page):
    cells = [cell.text for cell in page.all("td")]
    for each in kept.document.inputs:
        assert cells[cells.index(each.sha256) - 1] == each.name


def test_picture_left_out_is_shown_with_its_reason(page):
    (section,) = [s for s in page.all("section") if s.all("h2") and "Left out" in s.text[:8]]
    name, why = (cell.text for cell in section.all("td")[:2])
    assert name == WITHOUT_TARGET
    assert why.startswith("no pattern of points is seen")
    (thumbnail,) = page.all("img")
    assert WITHOUT_TARGET in thumbnail.attributes["alt"]


def poses_of(page):
    return {pose.all("span", "name")[0].text: pose for pose in page.all("details", "pose")}


def test_marks_lie_on_the_points_of_points_csv(kept, page):
    for name, pose in poses_of(page).items():
        rows = [r for r in csv.DictReader(io.StringIO(kept.points_csv)) if r["image"] == name]
        for kind, mark in (("dot", "dot"), ("stripe", "line")):
            for layer, u, v in (("seen", "u", "v"), ("corrected", "u_corrected", "v_corrected")):
                (path,) = [
                    p for p in pose.all("path")
                    if p.attributes.get("marker-mid") == f"url(#{layer}-{mark})"
                ]  # fmt: skip
                drawn = np.array(re.findall(r"[\d.]+", path.attributes["d"]), dtype=float)
                wanted = [(float(r[u]), float(r[v])) for r in rows if r["kind"] == kind]
                # Written with two decimals.
                np.testing.assert_allclose(drawn.reshape(-1, 2), wanted, atol=0.0051)


def test_picture_under_the_marks_is_the_part_of_the_source_at_its_place(kept, page):
    for name, pose in poses_of(page).items():
        (image,) = pose.all("image")
        jpeg = base64.b64decode(image.attributes["href"].partition(",")[2])
        shown = cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_UNCHANGED)
        x, y, width, height = (float(image.attributes[k]) for k in ("x", "y", "width", "height"))
        # Pixel (0, 0) is the centre of the top-left pixel: a picture begins half a pixel before.
        left, top = int(x + 0.5), int(y + 0.5)
        part = read_picture(kept.folder / name)[top : top + int(height), left : left + int(width)]
        assert shown.ndim == 2
        wanted = cv2.resize(part, shown.shape[::-1], interpolation=cv2.INTER_AREA)
        alike = cv2.matchTemplate(wanted, shown[3:-3, 3:-3], cv2.TM_CCOEFF_NORMED)
        # Of all shifts by up to 3 px it fits best at none.
        assert np.unravel_index(alike.argmax(), alike.shape) == (3, 3)


def test_worst_pose_stands_first(kept):
    document, points = by_hand(kept, [0.1, 0.4, 0.05, 0.2])
    page = read_page(calibration_report(document, points))
    order = [f"pose{place}.png" for place in (1, 3, 0, 2)]
    assert list(poses_of(page)) == order
    table = page.all("table")[-1].all("tbody")[0].all("tr")
    assert [row.children[0].text for row in table] == order
    assert [row.children[2].text for row in table] == ["0.400", "0.200", "0.100", "0.0500"]


def test_pose_whose_stripe_was_refused_stands_before_all_that_fit(kept):
    document, points = by_hand(kept, [0.1, 0.4, 0.05])
    lines = [
        line.removesuffix("1,") + "0,outlier" if line.startswith("pose2.png,stripe") else line
        for line in points.splitlines()
    ]
    page = read_page(calibration_report(document, "\n".join(lines)))
    assert next(iter(poses_of(page))) == "pose2.png"
    assert "40 stripe: outlier" in page.text


def test_pose_that_was_left_out_stands_first_and_is_drawn_as_seen(kept):
    document, points = by_hand(kept, [0.1, 0.4, 0.05])
    document = document.model_copy(update={"left_out": {"pose2.png": "pose2.png: it does not fit"}})
    lines = points.splitlines()
    for i, line in enumerate(lines):
        if line.startswith("pose2.png"):
            lines[i] = ",".join([*line.split(",")[:8], "", "", "0", "it does not fit"])
    page = read_page(calibration_report(document, "\n".join(lines)))
    name, pose = next(iter(poses_of(page).items()))
    assert name == "pose2.png"
    assert "left out: it does not fit" in pose.text
    assert len(pose.all("g", "unused")[0].all("circle")) == DOTS


def test_page_without_sources_has_all_but_the_pictures(kept):
    page = read_page(calibration_report(kept.document, kept.points_csv))
    assert not page.all("image")
    assert len(poses_of(page)) == 4
    assert "No picture:" in page.text


def test_twenty_poses_make_three_megabytes_at_most(kept, tmp_path, rng):
    """Noise is the picture that packs worst."""
    document, points = by_hand(kept, np.linspace(0.1, 0.2, 20), stripe=100)
    save(tmp_path / "pose0.png", noise(rng))
    for place in range(1, 20):
        shutil.copy(tmp_path / "pose0.png", tmp_path / f"pose{place}.png")
    text = calibration_report(document, points, [tmp_path])
    assert len(read_page(text).all("image")) == 20
    assert len(text.encode()) <= 3_000_000


def test_of_many_poses_all_are_listed_and_the_worst_are_drawn(kept):
    document, points = by_hand(kept, np.linspace(0.1, 0.2, 50))
    page = read_page(calibration_report(document, points))
    assert list(poses_of(page)) == [f"pose{place}.png" for place in range(49, 9, -1)]
    assert len(page.all("table")[-1].all("tbody")[0].all("tr")) == 50
    assert "The 40 worst are drawn" in page.text


def test_report_into_a_folder_that_is_not_there_is_refused_in_one_line(kept, tmp_path, capsys):
    arguments = ["calibrate", str(kept.folder), "--target", TARGET]
    arguments += ["--out", str(tmp_path / "c.json"), "--report", str(tmp_path / "no" / "r.html")]
    assert run(build_app("calibrate"), arguments) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_two_pictures_of_one_name_are_each_drawn_with_their_own_points(kept):
    document, points = by_hand(kept, [0.1, 0.4])
    page = read_page(calibration_report(document, points.replace("pose1", "pose0")))
    poses = page.all("details", "pose")
    assert [pose.all("span", "name")[0].text for pose in poses] == ["pose0.png"] * 2
    assert ["0.400 px" in poses[0].text, "0.100 px" in poses[1].text] == [True, True]
    assert not page.all("image")
