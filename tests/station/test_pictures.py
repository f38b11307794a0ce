"""Files become 8-bit grey pictures, or are refused in one line."""

import cv2
import numpy as np
import pytest

from station.errors import InputUnusable
from station.pictures import pictures_of, read_picture


@pytest.fixture
def grey(rng):
    return rng.integers(0, 256, (20, 30), dtype=np.uint8)


def test_grey_picture_is_read_unchanged(tmp_path, grey):
    cv2.imwrite(str(tmp_path / "a.png"), grey)
    np.testing.assert_array_equal(read_picture(tmp_path / "a.png"), grey)


def test_colour_with_transparency_is_turned_to_the_grey_it_shows(tmp_path, grey):
    four = np.dstack([grey, grey, grey, 255 - grey])
    cv2.imwrite(str(tmp_path / "a.png"), four)
    np.testing.assert_array_equal(read_picture(tmp_path / "a.png"), grey)


@pytest.mark.parametrize("bits", [8, 10, 12, 16])
def test_deep_picture_keeps_its_full_scale(tmp_path, grey, bits):
    grey[0, 0] = 255
    deep = np.rint(grey * ((2**bits - 1) / 255)).astype(np.uint16)
    cv2.imwrite(str(tmp_path / "a.png"), deep)
    np.testing.assert_array_equal(read_picture(tmp_path / "a.png"), grey)


@pytest.mark.parametrize("content", [b"", b"no picture", b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"])
def test_file_that_is_no_picture_is_refused_by_name(tmp_path, content):
    (tmp_path / "a.png").write_bytes(content)
    with pytest.raises(InputUnusable, match=r"a\.png: .* no whole picture"):
        read_picture(tmp_path / "a.png")


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".tif", ".bmp"])
def test_picture_cut_short_is_not_read_as_a_grey_rest(tmp_path, grey, suffix):
    path = tmp_path / f"a{suffix}"
    cv2.imwrite(str(path), grey)
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])
    with pytest.raises(InputUnusable, match="no whole picture"):
        read_picture(path)


def test_png_cut_short_is_refused_without_a_word_of_the_decoder(tmp_path, grey, capfd):
    whole = cv2.imencode(".png", grey)[1].tobytes()
    (tmp_path / "a.png").write_bytes(whole[:-20])
    with pytest.raises(InputUnusable, match="no whole picture"):
        read_picture(tmp_path / "a.png")
    assert capfd.readouterr() == ("", "")


def test_what_file_managers_leave_in_a_folder_is_passed_over(tmp_path, grey):
    for name in (".DS_Store", "Thumbs.db", "._im1.png", "notes.txt"):
        (tmp_path / name).write_bytes(b"\0\5\x16\7")
    (tmp_path / "folder.png").mkdir()
    cv2.imwrite(str(tmp_path / "im1.png"), grey)
    assert [p.name for p in pictures_of(tmp_path)] == ["im1.png"]


@pytest.mark.parametrize(
    "pixels",
    [
        pytest.param(lambda grey: np.dstack([grey, grey, grey]), id="colour"),
        pytest.param(lambda grey: np.dstack([grey] * 3).astype(np.uint16) * 257, id="deep colour"),
        pytest.param(lambda grey: np.dstack([grey] * 4).astype(np.uint16) * 257, id="deep RGBA"),
    ],
)
def test_grey_kept_in_any_number_of_channels_is_the_same_grey(tmp_path, grey, pixels):
    grey[0, 0] = 255
    cv2.imwrite(str(tmp_path / "a.png"), pixels(grey))
    np.testing.assert_array_equal(read_picture(tmp_path / "a.png"), grey)


def test_picture_of_floating_point_numbers_is_refused_with_what_is_allowed(tmp_path, grey):
    cv2.imwrite(str(tmp_path / "a.tiff"), grey.astype(np.float32) / 255.0)
    with pytest.raises(InputUnusable, match="float32; allowed: 8 or 16 bits"):
        read_picture(tmp_path / "a.tiff")


def test_folder_is_read_in_natural_order(tmp_path, grey):
    for name in ("im10.png", "im2.PNG", "im1.png", "notes.txt"):
        (tmp_path / name).write_bytes(cv2.imencode(".png", grey)[1].tobytes())
    assert [p.name for p in pictures_of(tmp_path)] == ["im1.png", "im2.PNG", "im10.png"]


@pytest.mark.parametrize(
    ("name", "said"),
    [("absent.png", "no such file"), ("notes.txt", "not a known kind"), ("", "without")],
)
def test_source_that_is_none_is_refused_with_what_is_allowed(tmp_path, name, said):
    (tmp_path / "notes.txt").write_text("x")
    with pytest.raises(InputUnusable, match=said):
        pictures_of(tmp_path / name)
