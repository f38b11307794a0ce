"""What a camera looks at: every source gives its pictures in order, over and over."""

import cv2
import numpy as np
import pytest
from simulated_pictures import numbered_pictures

from station.errors import InputUnusable
from station.recording import RecordingWriter
from station.scenes import Light
from station.simulated import (
    ArraySource,
    PictureFolder,
    RecordingSource,
    SceneKind,
    render_scenes,
)
from station.simulated.registers import DEFAULT_EXPOSURE_US

PICTURES = numbered_pictures(3, 64, 48)


def served(source, count):
    return [source.frame(index, DEFAULT_EXPOSURE_US) for index in range(count)]


def assert_in_order(frames):
    for index, frame in enumerate(frames):
        np.testing.assert_array_equal(frame, PICTURES[index % len(PICTURES)])


def write_pictures(folder, pictures):
    for number, picture in enumerate(pictures):
        cv2.imwrite(str(folder / f"im{number + 8}.png"), picture)  # im8, im9, im10


def test_arrays_come_in_order_over_and_over():
    source = ArraySource(PICTURES)
    assert (source.width, source.height) == (64, 48)
    assert_in_order(served(source, 7))


@pytest.mark.parametrize(
    "frames",
    [
        [],
        [np.zeros((4, 4))],
        [np.zeros((4, 4, 3), np.uint8)],
        [np.zeros((4, 4), np.uint8), np.zeros((4, 5), np.uint8)],
    ],
    ids=["none", "not uint8", "colour", "two sizes"],
)
def test_arrays_that_are_no_pictures_of_one_size_are_refused(frames):
    with pytest.raises(ValueError, match="picture"):
        ArraySource(frames)


def test_a_folder_is_served_in_natural_order(tmp_path):
    write_pictures(tmp_path, PICTURES)
    source = PictureFolder(tmp_path)
    assert len(source) == 3
    assert_in_order(served(source, 7))


def test_pictures_of_a_large_folder_are_read_again_when_they_are_due(tmp_path, monkeypatch):
    monkeypatch.setattr("station.simulated.picture_folder._REMEMBERED", 1)
    write_pictures(tmp_path, PICTURES)
    assert_in_order(served(PictureFolder(tmp_path), 7))


def test_a_folder_of_pictures_of_two_sizes_is_refused_by_name(tmp_path):
    write_pictures(tmp_path, [PICTURES[0], PICTURES[1][:40]])
    with pytest.raises(InputUnusable, match=r"im9.png: 64 × 40 px"):
        PictureFolder(tmp_path)


@pytest.mark.parametrize("what", ["empty", "missing", "a file"])
def test_what_is_no_folder_of_pictures_is_refused(tmp_path, what):
    paths = {"empty": tmp_path, "missing": tmp_path / "none", "a file": tmp_path / "f.txt"}
    if what == "a file":
        paths[what].write_text("no picture")
    with pytest.raises(InputUnusable, match="folder"):
        PictureFolder(paths[what])


def test_a_recording_is_served_in_order_over_and_over(tmp_path):
    path = tmp_path / "r.mcap"
    with RecordingWriter(path) as writer:
        for number, picture in enumerate(PICTURES, start=1):
            writer.write_frame("left", number, number, number, picture.data, 64, 48)
    source = RecordingSource(path)
    assert (source.sensor, source.width, source.height) == ("left", 64, 48)
    assert_in_order(served(source, 7))


def test_a_recording_without_that_sensor_is_refused(tmp_path):
    path = tmp_path / "r.mcap"
    with RecordingWriter(path) as writer:
        writer.write_frame("left", 1, 1, 1, PICTURES[0].data, 64, 48)
    with pytest.raises(InputUnusable, match="'right'"):
        RecordingSource(path, "right")


@pytest.fixture
def two_scenes(monkeypatch):
    monkeypatch.setattr("station.simulated.scene_source.SCENES", 2)


@pytest.mark.usefixtures("two_scenes")
def test_a_scene_comes_round_the_same_and_brightens_with_the_exposure():
    scenes = render_scenes(SceneKind.CYLINDER, Light.DIM, seed=3)
    first, _, again = served(scenes, 3)
    np.testing.assert_array_equal(first, again)
    brighter = scenes.frame(0, 2.0 * DEFAULT_EXPOSURE_US)
    assert brighter.mean() > 1.3 * first.mean()
    np.testing.assert_array_equal(scenes.frame(2, DEFAULT_EXPOSURE_US), first)


@pytest.mark.usefixtures("two_scenes")
def test_a_scene_stands_for_a_sequence_and_its_laser_can_be_switched_off():
    scenes = render_scenes(SceneKind.TARGET, Light.GOOD, seed=3, frames_per_scene=3)
    first, second, third, next_pose = served(scenes, 4)
    np.testing.assert_array_equal(first, second)
    np.testing.assert_array_equal(first, third)
    assert not np.array_equal(first, next_pose)
    dark = scenes.frame_laser_off(1, DEFAULT_EXPOSURE_US)
    # The stripe, 240 counts, and nothing else is gone.
    lit = first.astype(int) - dark.astype(int)
    assert (lit > 50).sum() > 500
    assert (lit < -50).sum() == 0


@pytest.mark.usefixtures("two_scenes")
def test_the_same_seed_renders_the_same_scene():
    one, other = (render_scenes(SceneKind.CYLINDER, Light.GOOD, seed=5) for _ in range(2))
    np.testing.assert_array_equal(one.frame(0, 1e4), other.frame(0, 1e4))


@pytest.mark.slow
@pytest.mark.parametrize("kind", list(SceneKind))
@pytest.mark.parametrize("light", list(Light))
def test_every_scene_renders_in_every_light(kind, light):
    source = render_scenes(kind, light)
    pictures = served(source, 12)
    assert {picture.shape for picture in pictures} == {(1088, 2048)}
    # In dim light a dot is a tenth of its 150 counts; dark pixels have 3, with a noise of 0.4.
    assert all(picture.max() > 10 for picture in pictures)
