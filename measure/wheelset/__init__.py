"""What two rigs, or a wheel that rolls past one, say beyond the profile: axle and radius."""

from measure.wheelset.back_to_back import BackToBack, back_to_back
from measure.wheelset.diameter import Diameter, wheel_diameter
from measure.wheelset.track_frame import TrackFrame

__all__ = ["BackToBack", "Diameter", "TrackFrame", "back_to_back", "wheel_diameter"]
