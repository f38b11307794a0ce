"""points.csv tells every point as it was, and refuses in one line what could mislead a solve."""

import csv
import io
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from calib import (
    Calibration,
    CameraModel,
    CameraRole,
    Cause,
    LaserSensor,
    LightPlane,
    Method,
    RigidTransform,
    SolvedPoints,
    SolvedRigView,
    SolvedView,
    SolveReport,
    StripePoints,
    Target,
    TargetPoints,
    Termination,
    View,
)
from station.documents import POINT_COLUMNS, points_csv, rig_points_csv, views_from_points
from station.errors import InputUnusable

TARGET = Target.parse("dots:7x8:12")


@pytest.fixture
def view(rng):
    row, col = np.divmod(np.arange(56), 8)
    angle = 0.7
    along = rng.uniform(-300, 300, 40)
    return View(
        'pose, "one".png',
        TargetPoints(
            row=row,
            col=col,
            centre_px=rng.uniform(0, 1000, (56, 2)),
            sigma_px=rng.uniform(0.02, 0.2, (56, 2)),
            cause=(Cause.GLARE, *[Cause.NONE] * 55),
        ),
        StripePoints(
            centre_px=[500, 500] + np.outer(along, [np.cos(angle), np.sin(angle)]),
            normal=np.tile([-np.sin(angle), np.cos(angle)], (40, 1)),
            sigma_px=rng.uniform(0.02, 0.2, 40),
            width_px=np.full(40, 2.0),
            peak=np.full(40, 100.0),
            saturated=np.zeros(40, dtype=bool),
            cause=(Cause.NONE,) * 40,
        ),
    )


@pytest.fixture
def calibration(view):
    camera = CameraModel.from_parameters(
        np.array([1000.0, 1000, 500, 500, 0, 0, 0, 0, 0]), width=1000, height=1000
    )
    solved = SolvedView(
        view.name,
        RigidTransform.identity(),
        SolvedPoints(view.points.centre_px + 1.0, np.arange(56) > 0, view.points.cause),
        SolvedPoints(view.stripe.centre_px - 1.0, np.ones(40, dtype=bool), view.stripe.cause),
    )
    report = SolveReport(Termination.CONVERGED, 1, 0.0, 1.0, 1.0, 0.0, 0.0, CameraRole.HELD)
    sensor = LaserSensor.exact(camera, LightPlane.from_coefficients([0, 0, 1, -500]))
    return Calibration(sensor, Method.JOINT, 0.1, 0.1, (solved,), report, (), (view,))


def test_points_come_back_as_they_were_written(view, calibration):
    (back,) = views_from_points(points_csv(calibration), TARGET, name="points.csv")
    # Six decimals are written.
    np.testing.assert_array_equal(back.points.row, view.points.row)
    np.testing.assert_allclose(back.points.centre_px, view.points.centre_px, atol=6e-7)
    np.testing.assert_allclose(back.points.sigma_px, view.points.sigma_px, atol=6e-7)
    np.testing.assert_allclose(back.stripe.centre_px, view.stripe.centre_px, atol=6e-7)
    np.testing.assert_allclose(back.stripe.sigma_px, view.stripe.sigma_px, atol=2e-6)
    across = np.abs(np.einsum("ni,ni->n", back.stripe.normal, view.stripe.normal))
    np.testing.assert_allclose(across, 1.0, atol=1e-9)


def test_rows_tell_correction_use_and_reason(view, calibration):
    rows = list(csv.DictReader(io.StringIO(points_csv(calibration))))
    assert tuple(rows[0]) == POINT_COLUMNS
    assert (rows[0]["used"], rows[0]["reason"]) == ("0", "glare")
    assert float(rows[1]["u_corrected"]) - float(rows[1]["u"]) == pytest.approx(1.0, abs=2e-6)
    assert {row["kind"] for row in rows} == {"dot", "stripe"}


def test_the_radius_of_dots_as_seen_comes_back(view, calibration):
    seen = replace(view, dot_radius=0.2461)
    (back,) = views_from_points(
        points_csv(replace(calibration, seen=(seen,))), TARGET, name="points.csv"
    )
    assert back.dot_radius == 0.2461


def test_a_file_without_a_radius_tells_none(view, calibration):
    (back,) = views_from_points(points_csv(calibration), TARGET, name="points.csv")
    assert back.dot_radius is None


def test_view_left_out_has_its_reason_in_every_row(view, calibration):
    left_out = SolvedView(view.name, None, None, None, left_out="too few dots")
    answer = Calibration(
        calibration.sensor, Method.JOINT, 0.1, 0.1, (left_out,), calibration.solve, (), (view,)
    )
    rows = list(csv.DictReader(io.StringIO(points_csv(answer))))
    assert {(row["used"], row["reason"]) for row in rows} == {("0", "too few dots")}


def test_each_sensor_of_a_rig_has_the_points_of_its_own_pictures(view, calibration):
    (solved,) = calibration.views
    pictures = [
        SolvedRigView("showing 1", sensor, "board", 0, solved, view)
        for sensor in ("inner", "outer")
    ]
    sensors = [SimpleNamespace(name=name) for name in ("inner", "outer", "blind")]
    rig = SimpleNamespace(rig=SimpleNamespace(sensors=sensors), views=pictures)
    texts = rig_points_csv(rig)
    assert texts["inner"] == texts["outer"] == points_csv(calibration)
    assert texts["blind"].split() == [",".join(POINT_COLUMNS)]


HEADER = "image,kind,row,col,u,v,sigma_u,sigma_v\n"
WITH_RADIUS = HEADER.replace("\n", ",dot_radius_pitches\n")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "no column image"),
        ("image,kind,row\n", "no column col, u, v"),
        (HEADER, "no points"),
        (HEADER + "a,dot,0,0,nan,1,1,1\n", "line 2: .* not finite"),
        (HEADER + "a,dot,0,0,x,1,1,1\n", "line 2: .* not a number"),
        (HEADER + "a,dot,0,0,1\n", "line 2: .* not a number"),
        (HEADER + "a,blob,0,0,1,1,1,1\n", "kind 'blob'; allowed: dot, stripe"),
        (HEADER + "a,dot,0,0,1,1,0,0\n", "sigma 0, 0; allowed: positive"),
        (HEADER + "a,dot,0,0,1,1,0.1,0\n", "sigma 0.1, 0; allowed: positive"),
        (HEADER + "a,dot,0,0,1,1,-1,1\n", "sigma -1, 1; allowed: positive"),
        (HEADER + "a,dot,0,0,1,1,1e-300,1\n", "sigma 1e-300, 1; allowed: positive"),
        (HEADER + "a,dot,0,0,1,1,1,1e300\n", r"sigma 1, 1e\+300; allowed: positive"),
        (HEADER + "a,dot,0,0,1e308,1,1,1\n", r"a point at 1e\+308, 1; allowed"),
        (HEADER + "a,dot,0.5,0,1,1,1,1\n", "row '0.5' is not a whole number"),
        (HEADER + "a,dot,inf,0,1,1,1,1\n", "row 'inf' is not a whole number"),
        (HEADER + ",dot,0,0,1,1,1,1\n", "line 2: no name of an image"),
        (HEADER + "a,dot,0,0,1,5,1,5,1,1\n", "line 2: more fields than the header"),
        ("u," + HEADER + "1,a,dot,0,0,1,1,1,1\n", "column u stands twice"),
        (HEADER + "a,stripe,,,1,1,1,1\na,stripe,,,2,1,1,1\n" * 2, "line 4: the stripe point"),
        (HEADER.replace(",", ";") + "a;dot;0;0;1,5;1;1;1\n", "u '1,5' is not a number"),
        (HEADER + "a,dot,7,0,1,1,1,1\n", "row 7, col 0; allowed"),
        (HEADER + "a,dot,0,0,1,1,1,1\n" * 2, "line 3: .* line 2 already"),
        (WITH_RADIUS + "a,dot,0,0,1,1,1,1,0.6\n", "dot_radius_pitches 0.6; allowed: between"),
        (WITH_RADIUS + "a,dot,0,0,1,1,1,1,r\n", "dot_radius_pitches 'r' is not a number"),
    ],
)
def test_file_that_could_mislead_is_refused_with_its_line(text, said):
    with pytest.raises(InputUnusable, match=said):
        views_from_points(text, TARGET, name="points.csv")


@pytest.mark.parametrize(
    "written",
    [
        pytest.param(lambda text: text.replace(",", ";"), id="semicolons"),
        pytest.param(lambda text: text.replace(",", "\t"), id="tabs"),
        pytest.param(lambda text: text.replace(",", ", "), id="spaces"),
        pytest.param(lambda text: text.replace("\n", "\r\n"), id="lines of DOS"),
        pytest.param(lambda text: text.replace(",0,1,", ",0.0,1.0,"), id="whole floats"),
        pytest.param(lambda text: text + "\n\n", id="empty lines"),
    ],
)
def test_table_of_another_program_is_read_the_same(view, calibration, written):
    text = points_csv(calibration)
    (plain,) = views_from_points(text, TARGET, name="points.csv")
    (other,) = views_from_points(written(text), TARGET, name="points.csv")
    np.testing.assert_array_equal(other.points.centre_px, plain.points.centre_px)
    np.testing.assert_array_equal(other.points.row, plain.points.row)
    np.testing.assert_array_equal(other.stripe.sigma_px, plain.stripe.sigma_px)


def test_a_stripe_of_one_point_is_read_and_left_to_the_solver():
    (view,) = views_from_points(HEADER + "a,stripe,,,1,2,0.3,0.4\n", TARGET, name="points.csv")
    assert view.stripe.centre_px.tolist() == [[1.0, 2.0]]
    np.testing.assert_allclose(view.stripe.sigma_px, 0.5)
