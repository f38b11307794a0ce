"""camera.json keeps a camera to the last digit and refuses what is no camera."""

import json

import numpy as np
import pytest

from calib import CameraModel
from station.documents import CameraDocument
from station.errors import InputUnusable


@pytest.fixture
def camera(rng):
    factor = np.zeros((9, 9))
    factor[:6, :6] = rng.normal(size=(6, 6))
    return CameraModel.from_parameters(
        np.array([2315.8488, 2312.4282, 1004.8597, 555.3317, -0.1267, 0.1204, 0, 0, 0]),
        width=2048,
        height=1088,
        covariance=factor @ factor.T,
    )


def test_camera_comes_back_as_it_was(tmp_path, camera):
    CameraDocument.from_model(camera).write(tmp_path / "camera.json")
    back = CameraDocument.read(tmp_path / "camera.json").model()
    np.testing.assert_array_equal(back.parameters, camera.parameters)
    np.testing.assert_array_equal(back.covariance, camera.covariance)
    assert (back.width, back.height) == (2048, 1088)


def test_bare_file_of_another_tool_is_enough(tmp_path):
    path = tmp_path / "camera.json"
    path.write_text(json.dumps({"fx": 2, "fy": 2, "cx": 1, "cy": 1, "width": 3, "height": 3}))
    camera = CameraDocument.read(path).model()
    assert camera.k1 == 0.0
    assert not camera.covariance.any()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "not a CameraDocument"),
        ("{}", "fx: Field required"),
        ('{"fx": -1, "fy": 2, "cx": 1, "cy": 1, "width": 3, "height": 3}', "fx: .*greater than 0"),
        (
            '{"fx": 1, "fy": 2, "cx": 1, "cy": 1, "width": 3, "height": 3, "estimated": ["fx"]}',
            "covariance must be 1 x 1",
        ),
    ],
)
def test_file_that_is_no_camera_is_refused(tmp_path, text, said):
    (tmp_path / "camera.json").write_text(text)
    with pytest.raises(InputUnusable, match=said):
        CameraDocument.read(tmp_path / "camera.json")


def test_file_that_cannot_be_written_is_refused_and_leaves_nothing(tmp_path, camera):
    with pytest.raises(InputUnusable, match="cannot be written"):
        CameraDocument.from_model(camera).write(tmp_path / "absent" / "camera.json")
    assert list(tmp_path.iterdir()) == []
