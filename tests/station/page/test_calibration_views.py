"""What the page of calibrations shows, as values: figures of reports, drift, what is in force."""

import json
import math
from datetime import UTC, datetime

import numpy as np
import pytest
from demo_station_truth import HEIGHT_PX, INNER, OUTER, RIGHT, WIDTH_PX

from calib import Target
from station.documents import CalibrationDocument, RigDocument
from station.documents.points import POINT_COLUMNS
from station.errors import InputUnusable
from station.operations import FramePlace
from station.page.calibration.figures import comparison_of, figures_of, size_of
from station.page.calibration.history import drift_of, history_of
from station.page.calibration.made import made
from station.page.calibration.opening import TargetForm, order_of, suggested_name
from station.page.calibration.overview import overview_of
from station.page.calibration.pictures import picture_of, pictures_drawn
from station.page.calibration.report import report_of
from station.page.calibration.rig_pictures import SolvedOnRig, sensors_with_points
from station.report import evidence_of
from station.settings import load_settings
from station.store import (
    Calibration,
    CalibrationPoints,
    RigCalibration,
    RigCalibrationPoints,
    Store,
    active,
)


@pytest.fixture(scope="module")
def store(demo_data):
    store = Store.open(f"sqlite:///{demo_data.folder / 'data' / 'station.sqlite'}")
    yield store
    store.close()


@pytest.fixture(scope="module")
def first(store, demo_data):
    name = demo_data.told.calibrations["right-1"]
    with store.look() as session:
        row, points = session.get(Calibration, name), session.get(CalibrationPoints, name)
    return CalibrationDocument.model_validate_json(row.document), points.csv


@pytest.fixture(scope="module")
def figures(first):
    return figures_of(*first, None)


def test_figures_hold_no_number_that_json_does_not_know(figures):
    assert json.loads(json.dumps(figures, allow_nan=False)) == figures


def test_pictures_are_those_of_the_calibration_with_its_residuals(first, figures):
    document, _ = first
    assert {each["name"] for each in figures["pictures"]} >= {p.image for p in document.poses}
    squares = [each["dots_rms_px"] ** 2 * each["dots_used"] for each in figures["pictures"]]
    count = sum(each["dots_used"] for each in figures["pictures"])
    assert math.sqrt(sum(squares) / count) == pytest.approx(document.rms.dots_px, rel=1e-3)


def test_histograms_count_every_deviation(figures):
    for kind in ("dots", "stripe"):
        histogram = figures["histograms"][kind]
        assert sum(histogram["counts"]) + histogram["beyond"] == histogram["points"] > 100
        assert 0.5 < histogram["rms"] < 2.0


def test_the_map_of_the_sheet_is_sigma_on_the_sheet(first, figures):
    document, _ = first
    sheet = figures["sheet"]
    at = len(sheet["values_mm"]) // 2
    row, column = divmod(at, sheet["columns"])
    pixel = (np.array([column, row]) + 0.5) * sheet["step_px"] - 0.5
    expected_mm = document.laser_sensor().sigma_on_sheet(pixel[None])[0]
    assert sheet["values_mm"][at] == pytest.approx(expected_mm, abs=1e-5)


def test_a_picture_has_its_frame_and_its_points(first):
    document, points = first
    name = document.poses[0].image
    place = next(
        at
        for at, each in enumerate(figures_of(document, points, None)["pictures"])
        if each["name"] == name
    )
    size_px, frames = size_of(document), {name: FramePlace("session.x.right", 3)}
    told = picture_of(document, size_px, points, place, frames)
    assert told["frame"] == {"recording": "session.x.right", "number": 3}
    dots = told["dots"]
    deviation = np.array(dots["seen_px"]) - np.array(dots["corrected_px"])
    assert np.sqrt((deviation**2).sum(axis=1).mean()) == pytest.approx(
        told["dots_rms_px"], abs=2e-3
    )
    assert picture_of(document, size_px, points, 10_000, {}) is None
    assert picture_of(document, size_px, points, place, {})["frame"] is None


def test_a_rig_keeps_the_points_of_each_sensor_and_their_residuals_are_the_rigs(store, demo_data):
    name = demo_data.told.calibrations["rig"]
    with store.look() as session:
        document = RigDocument.model_validate_json(session.get(RigCalibration, name).document)
        assert sensors_with_points(session, name) == [INNER, OUTER]
        texts = [session.get(RigCalibrationPoints, (name, each)).csv for each in (INNER, OUTER)]
    pictures = [evidence_of(text) for text in texts]
    squares = [SolvedOnRig.of(each).rms.dots_px ** 2 for each in pictures]
    counts = [sum(int(one.dots.used.sum()) for one in each) for each in pictures]
    # The square of all is the mean of each sensor's, by its dots.
    both_px = math.sqrt(np.average(squares, weights=counts))
    assert both_px == pytest.approx(document.rms.dots_px, rel=1e-3)
    drawn = pictures_drawn(SolvedOnRig.of(pictures[0]), pictures[0], (WIDTH_PX, HEIGHT_PX))
    assert json.loads(json.dumps(drawn, allow_nan=False)) == drawn
    assert {each["distance_mm"] for each in drawn["pictures"]} == {None}  # no pose is kept


def test_a_picture_that_a_rig_left_out_says_why():
    row = "a.mcap#1,dot,0,{},1,1,0.1,0.1,,,0,no board,0.2\n"
    text = f"{','.join(POINT_COLUMNS)}\n{row.format(0)}{row.format(1)}"
    (drawn,) = pictures_drawn(SolvedOnRig.of(evidence_of(text)), evidence_of(text), (8, 8))[
        "pictures"
    ]
    assert drawn["left_out"] == "no board"
    assert drawn["dots_rms_px"] is None


def test_a_calibration_does_not_differ_from_itself_and_another_camera_is_no_match(first):
    document, _ = first
    same = comparison_of(document, document, 32)
    assert same["rms_mm"] == same["largest_mm"] == 0.0
    assert same["agree"]
    camera = document.camera.model_copy(update={"width": document.camera.width * 2})
    other = comparison_of(document, document.model_copy(update={"camera": camera}), 32)
    assert "pixel in common" in other["why_not"]


def test_drift_is_what_each_calibration_says_with_its_uncertainty(store):
    with store.look() as session:
        history = history_of(session, RIGHT)
    drift = drift_of(history)
    assert len(drift["at_s"]) == len(history.points) >= 3
    assert drift["at_s"] == sorted(drift["at_s"])
    for point in history.points:
        assert point.mid_mm.value > point.offset_mm.value > 0.0
        assert 0.0 < point.mid_mm.u95 < 5.0
        assert 0.0 < point.angle_deg.u95 < 5.0
    assert json.dumps(drift, allow_nan=False)
    in_force = {row.calibration_id for row, _ in history.activations}
    assert in_force <= {each.calibration for each in history.points if each.activated}


class _Settings:
    """As much of a station as the overview asks for."""

    def __init__(self, settings):
        self.settings = settings


def test_the_overview_names_what_is_in_force_and_what_asks(store, demo_data):
    station = _Settings(load_settings(demo_data.folder / "station.toml"))
    with store.look() as session:
        overview = overview_of(session, station)
        present = active(session, RIGHT)
    of_right = next(each for each in overview.in_force if each.name == RIGHT)
    assert of_right.calibration == present.calibration_id
    assert of_right.gates == 4
    assert {each.kind for each in overview.in_force} == {"sensor", "rig"}
    assert overview.sessions
    assert all(row.sensor == RIGHT for row in overview.asking)


def test_all_calibrations_are_listed_with_their_outcome(store):
    with store.look() as session:
        rows = made(session)
        failed = next(each for each in rows if each.outcome == "failed")
        report = report_of(session, failed.id)
    assert [each.at for each in rows] == sorted((each.at for each in rows), reverse=True)
    assert {"sensor", "rig"} == {each.kind for each in rows}
    assert failed.reason
    assert not report.can_be_decided
    assert report.gates == ()


def test_a_form_describes_a_target():
    form = TargetForm("dots", 7, 8, 12.0, True, 6.0)
    assert form.target() == Target.parse("dots:7x8:12:dark:d=6")
    assert TargetForm("chessboard", 9, 6, 5.0, True, 3.0).target() == Target.parse(
        "chessboard:9x6:5"
    )
    with pytest.raises(InputUnusable, match="diameter"):
        TargetForm("dots", 7, 8, 12.0, False, 20.0).target()


def test_an_order_is_of_a_sensor_or_of_a_rig():
    target = Target.parse("dots:7x8:12")
    assert order_of("sensor:left", target).sensor == "left"
    assert order_of("rig:left", target).rig == "left"
    assert suggested_name(datetime(2026, 1, 2, 3, 4, tzinfo=UTC)) == "session-20260102-0304"
