"""A calibration of known figures, solved from points alone, and pictures that belong to it."""

from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import cv2
import numpy as np
import pytest

from calib import Cause, StripePoints, Target, TargetPoints, View
from station.documents import CalibrationDocument, points_csv
from station.pipeline import calibrate_sources
from station.scenes import paper_sensor, target_poses

TARGET = Target.parse("dots:7x8:12:d=6")
HOSTILE = "<script>alert('1')</script> & \"quotes\".png"
SIGMA_PX = 0.02
NOISY_SIGMA_PX = 0.2


@dataclass(frozen=True)
class Kept:
    """What is kept of a calibration: the document, the points, the folder of pictures."""

    document: CalibrationDocument
    points_csv: str
    folder: Path
    noisiest: str
    pose_names: tuple[str, ...]
