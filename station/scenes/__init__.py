"""Rendered scenes with known truth: a target, a wheel, a cylinder before the paper's sensor.

Physics rather than stickers: distortion, discs, a light sheet of Gaussian thickness, defocus,
flare, speckle, shot and read noise, saturation.
"""

from station.scenes.coat import Soiling
from station.scenes.cylinder_scene import CylinderScene, cylinder_poses
from station.scenes.detector import Detector
from station.scenes.installation import (
    Place,
    paper_sensor,
    projector_in_cam_mm,
    trackside_mounting,
)
from station.scenes.light import Light
from station.scenes.optics import Lens
from station.scenes.physics import Physics
from station.scenes.piece_scene import PieceScene, piece_pose
from station.scenes.poses import pose_through_dots, target_poses, target_scenes
from station.scenes.rail_scene import RailScene
from station.scenes.rigid_target import MountedBoard, RigidTarget
from station.scenes.showings import Showing, rig_showings
from station.scenes.target_scene import TargetScene
from station.scenes.wheel_faults import WheelFaults
from station.scenes.wheel_rig import WheelRig, sensor_as_built
from station.scenes.wheel_scene import WheelScene
from station.scenes.wheel_truth import TrueReadings, WheelTruth

__all__ = [
    "CylinderScene",
    "Detector",
    "Lens",
    "Light",
    "MountedBoard",
    "Physics",
    "PieceScene",
    "Place",
    "RailScene",
    "RigidTarget",
    "Showing",
    "Soiling",
    "TargetScene",
    "TrueReadings",
    "WheelFaults",
    "WheelRig",
    "WheelScene",
    "WheelTruth",
    "cylinder_poses",
    "paper_sensor",
    "piece_pose",
    "pose_through_dots",
    "projector_in_cam_mm",
    "rig_showings",
    "sensor_as_built",
    "target_poses",
    "target_scenes",
    "trackside_mounting",
]
