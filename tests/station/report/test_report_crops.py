"""Parts of pictures are small, at their place, and do not pile up while they are cut."""

import weakref

import cv2
import numpy as np
import pytest
from report_samples import by_hand, noise, save

from station.pipeline import Frame
from station.report import crops
from station.report.crops import Box, crop_of, crops_of
from station.report.evidence import evidence_of


def test_part_holds_all_points_and_stays_within_the_picture(kept):
    (picture,) = evidence_of(by_hand(kept, [0.1])[1])
    box = Box.around(picture, 1800, 900)
    low, high = picture.seen_px.min(axis=0), picture.seen_px.max(axis=0)
    assert (low >= [box.left, box.top]).all()
    assert (high <= [box.left + box.width - 1, box.top + box.height - 1]).all()
    assert box.left + box.width <= 1800
    assert box.top + box.height <= 900


@pytest.mark.parametrize("width", [1, 300, 2048])
def test_jpeg_of_the_worst_picture_is_small_enough(rng, width):
    crop = crop_of(noise(rng), Box(0, 0, width, width))
    assert len(crop.jpeg) <= 60_000


def test_dim_picture_is_brightened_and_a_bright_one_left(rng):
    picture = np.full((50, 50), 20, dtype=np.uint8)
    crop = crop_of(picture, Box(0, 0, 50, 50))
    assert crop.gain == pytest.approx(10.0)
    shown = cv2.imdecode(np.frombuffer(crop.jpeg, np.uint8), cv2.IMREAD_UNCHANGED)
    assert shown.mean() == pytest.approx(200.0, abs=1.0)
    assert crop_of(np.full((50, 50), 230, dtype=np.uint8), Box(0, 0, 50, 50)).gain == 1.0


def test_pictures_of_one_name_are_not_taken_for_each_other(tmp_path, rng):
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
        save(tmp_path / folder / "a.png", noise(rng))
    save(tmp_path / "two" / "b.png", noise(rng))
    boxes = {"a.png": Box(0, 0, 10, 10), "b.png": Box(0, 0, 10, 10)}
    found = crops_of([tmp_path / "one", tmp_path / "two"], boxes, frozenset())
    assert set(found) == {"b.png"}


def test_whole_pictures_do_not_pile_up(monkeypatch, rng):
    living = weakref.WeakSet()

    class Watched(np.ndarray):
        __hash__ = object.__hash__

    def frames(_sources):
        for number in range(8):
            picture = noise(rng).view(Watched)
            living.add(picture)
            assert len(living) <= 2, "pictures are kept"
            yield Frame(f"{number}", "source", number, picture)
            del picture

    monkeypatch.setattr(crops, "read_frames", frames)
    boxes = {f"{number}": Box(0, 0, 900, 900) for number in range(8)}
    assert len(crops_of([], boxes, frozenset())) == 8
