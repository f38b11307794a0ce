import cv2
import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from calib import Target
from station.scenes import Lens, Physics, paper_sensor


@pytest.fixture(scope="session", autouse=True)
def _one_thread():
    cv2.setNumThreads(1)


@pytest.fixture(scope="session")
def sensor():
    return paper_sensor()


@pytest.fixture(scope="session")
def target():
    return Target.parse("dots:7x8:12:d=6")


@pytest.fixture(scope="session")
def clear():
    """Physics under which only the geometry decides where a centroid lies."""
    return Physics(grain=0.0, speckle=0.0, lens=Lens(flare=(0.0, 0.0), corner=0.0))


@pytest.fixture(scope="session")
def ridge_of():
    """Return a function that moves points on a stripe, (N, 2) in order, to its centroid across."""

    def ridge_of(light, points_px, reach_px=6.0):
        along = np.gradient(points_px, axis=0)
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        across = np.column_stack([-along[:, 1], along[:, 0]])
        steps = np.arange(-reach_px, reach_px + 0.1, 0.25)
        places = points_px[:, None] + steps[:, None] * across[:, None]
        weight = map_coordinates(light, [places[..., 1], places[..., 0]], order=3)
        shift = (weight * steps).sum(axis=1) / weight.sum(axis=1)
        return points_px + shift[:, None] * across

    return ridge_of
