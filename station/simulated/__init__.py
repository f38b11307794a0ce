"""A simulated GigE Vision camera that no driver can tell from a real one.

It has what a station needs to be tried without a track: any address of the loopback network,
packets sent again, hardware triggers with exact times, and faults on demand.
"""

from station.simulated.camera import SimulatedCamera, parse_address
from station.simulated.counters import Statistics
from station.simulated.device import DeviceOptions
from station.simulated.device_clock import DeviceClock
from station.simulated.discovery import probe_camera
from station.simulated.faults import Faults
from station.simulated.identity import Identity
from station.simulated.picture_folder import PictureFolder
from station.simulated.playback import Playback, Shot
from station.simulated.process import MakeSource, SimulatedCameraProcess
from station.simulated.recording_source import RecordingSource
from station.simulated.scene_kind import SceneKind
from station.simulated.scenery import render_scenes
from station.simulated.sources import ArraySource, FrameSource, LaserSwitched, SceneSource

__all__ = [
    "ArraySource",
    "DeviceClock",
    "DeviceOptions",
    "Faults",
    "FrameSource",
    "Identity",
    "LaserSwitched",
    "MakeSource",
    "PictureFolder",
    "Playback",
    "RecordingSource",
    "SceneKind",
    "SceneSource",
    "Shot",
    "SimulatedCamera",
    "SimulatedCameraProcess",
    "Statistics",
    "parse_address",
    "probe_camera",
    "render_scenes",
]
