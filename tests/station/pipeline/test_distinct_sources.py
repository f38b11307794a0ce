"""Pictures of the same file name are told apart, and no picture counts twice."""

import shutil
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from calib import Cause, Target, TargetPoints, View
from station.errors import InputUnusable
from station.pipeline import calibrate_sources, observe_sources, read_frames
from station.pipeline.distinct_views import named_apart, without_copies
from station.pipeline.naming import distinct_names

TARGET = Target.parse("dots:7x8:12:d=6")


@pytest.fixture
def two_folders(poses, tmp_path):
    """The poses as two sessions that both began to count at 0."""
    for session in ("monday", "tuesday"):
        (tmp_path / session).mkdir()
    for index in range(6):
        session = "monday" if index < 3 else "tuesday"
        name = f"pose{index % 3}.png"
        shutil.copy(poses / "on" / f"pose{index}.png", tmp_path / session / name)
    return [tmp_path / "monday", tmp_path / "tuesday"]


def drawn(rng, name="a"):
    row, col = np.divmod(np.arange(56), 8)
    centre_px = rng.uniform(0.0, 1000.0, (56, 2))
    points = TargetPoints(row, col, centre_px, np.full((56, 2), 0.01), (Cause.NONE,) * 56)
    return View(name, points, None)


@pytest.mark.parametrize(
    ("paths", "names"),
    [
        (["a/1.png", "a/2.png"], ["1.png", "2.png"]),
        (["a/1.png", "b/1.png", "b/2.png"], ["a/1.png", "b/1.png", "2.png"]),
        (["x/a/1.png", "y/a/1.png", "y/b/1.png"], ["x/a/1.png", "y/a/1.png", "b/1.png"]),
        ([], []),
    ],
)
def test_a_name_has_as_much_of_the_path_as_tells_it_apart(paths, names):
    assert distinct_names([Path(path) for path in paths]) == names


def test_a_source_given_twice_is_refused(poses):
    with pytest.raises(InputUnusable, match=r"pose0\.png: given 2 times"):
        list(read_frames([poses / "on", poses / "on" / "pose0.png"]))


def test_points_of_two_folders_with_the_same_file_names_give_the_same_plane_again(
    two_folders, truth, tmp_path
):
    outcome = calibrate_sources(two_folders, TARGET, camera=truth.camera)
    named = {pose.image for pose in outcome.document.poses}
    assert named == {f"{day}/pose{i}.png" for day in ("monday", "tuesday") for i in range(3)}
    points = tmp_path / "points.csv"
    points.write_text(outcome.points_csv)
    again = calibrate_sources([points], TARGET, camera=truth.camera).document
    plane, same = outcome.document.plane, again.plane
    sigma_d = np.sqrt(outcome.document.plane_covariance[3][3])
    # Six decimals are kept of each coordinate, and no causes of single points.
    assert abs(plane.d - same.d) < 0.5 * sigma_d


def test_the_same_picture_under_two_names_counts_once(poses, tmp_path):
    for name in ("a.png", "b.png"):
        shutil.copy(poses / "on" / "pose0.png", tmp_path / name)
    seen = observe_sources([tmp_path], TARGET)
    assert [view.name for view in seen.views] == ["a.png"]
    assert seen.left_out == (("b.png", "a copy of a.png: the same points"),)


def test_pictures_of_one_pose_that_differ_by_their_noise_all_count(rng):
    first = drawn(rng)
    moved = first.points.centre_px + rng.normal(0.0, 0.01, (56, 2))
    second = replace(first, name="b", points=replace(first.points, centre_px=moved))
    assert without_copies([first, second]) == ([first, second], [])


def test_points_of_a_picture_in_another_order_are_a_copy(rng):
    first = drawn(rng)
    order = rng.permutation(56)
    points = first.points
    turned = TargetPoints(
        points.row[order], points.col[order], points.centre_px[order], points.sigma_px, points.cause
    )
    views, copies = without_copies([first, View("b", turned, None)])
    assert (views, [name for name, _ in copies]) == ([first], ["b"])


def test_views_of_points_files_are_named_by_their_file_where_another_has_the_name(rng):
    files = [("one.csv", [drawn(rng, "a"), drawn(rng, "b")]), ("two.csv", [drawn(rng, "a")])]
    names = [view.name for view in named_apart(files, taken=["c"])]
    assert names == ["one.csv:a", "b", "two.csv:a"]
    names = [view.name for view in named_apart(files[:1], taken=["b"])]
    assert names == ["a", "one.csv:b"]


def test_pictures_without_the_target_are_refused_with_the_reason_of_the_first(truth, tmp_path):
    for name in ("a", "b"):
        cv2.imwrite(str(tmp_path / f"{name}.png"), np.zeros((1088, 2048), np.uint8))
    with pytest.raises(Exception, match=r"left out before: 2, the first, a\.png: "):
        calibrate_sources([tmp_path], TARGET, camera=truth.camera)


def test_a_pitch_in_metres_is_told(poses, truth):
    target = Target.parse("dots:7x8:0.012:d=0.006")
    document = calibrate_sources([poses / "on"], target, camera=truth.camera).document
    assert any("is the pitch in mm?" in warning for warning in document.warnings)
