"""The camera that a recording keeps, read without the mathematics."""

import json
import subprocess
import sys

import pytest

from station.recording import CameraNumbers

CAMERA = {"fx": 2315.0, "fy": 2312.0, "cx": 1004.0, "cy": 555.0, "k1": -0.12, "width": 2048}


def test_the_numbers_are_those_of_the_calibration():
    document = json.dumps({"camera": CAMERA | {"height": 1088, "estimated": ["fx"]}})
    camera = CameraNumbers.of_calibration(document.encode())
    assert (camera.fx, camera.k1, camera.k3, camera.height) == (2315.0, -0.12, 0.0, 1088)


def test_a_camera_without_its_height_is_none():
    with pytest.raises(TypeError, match="height"):
        CameraNumbers.of_calibration(json.dumps({"camera": CAMERA}).encode())


def test_a_recorder_starts_without_the_mathematics():
    asked = "import sys, station.capture.recorder; print({'calib', 'scipy'} & set(sys.modules))"
    said = subprocess.run(
        [sys.executable, "-c", asked], check=True, capture_output=True, text=True, timeout=60
    )
    assert said.stdout.strip() == "set()"
