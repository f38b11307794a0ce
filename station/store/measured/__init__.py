"""Wheels that were measured: their rows, profiles and axles, early readings and replays."""

from station.store.measured.alarm_levels import WheelLevels, wheel_levels
from station.store.measured.axles import Appearance, axles_of, history_of, places_of, replace_axles
from station.store.measured.followings import (
    end_following,
    followings_of,
    forget_followed,
    keep_followed,
    note_followed,
)
from station.store.measured.measurements import add_measurements, profiles_of, wheels_of
from station.store.measured.replays import measured_by, note_measured, recordings_replayed

__all__ = [
    "Appearance",
    "WheelLevels",
    "add_measurements",
    "axles_of",
    "end_following",
    "followings_of",
    "forget_followed",
    "history_of",
    "keep_followed",
    "measured_by",
    "note_followed",
    "note_measured",
    "places_of",
    "profiles_of",
    "recordings_replayed",
    "replace_axles",
    "wheel_levels",
    "wheels_of",
]
