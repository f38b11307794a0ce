"""From a stripe on a wheel to gauge readings with their uncertainty.  Pure mathematics, mm."""

from measure.errors import MeasureError, ProfileTextInvalid, ReferenceInvalid, ReferenceUnknown
from measure.grouping import each_wheel, group_into_wheels
from measure.limits import Limit, Limits
from measure.mounting import Mounting
from measure.profile import Profile
from measure.profile_gauges import gauge_profile
from measure.profile_text import (
    MiniProfText,
    format_miniprof,
    parse_miniprof,
    parse_profile_csv,
    parse_profile_text,
)
from measure.quantities import Alarm, Quantity, Reading, Status
from measure.reference import ReferenceProfile, reference_profile
from measure.wheel import WheelFrame, WheelQuality, WheelReadings, measure_wheel

__all__ = [
    "Alarm",
    "Limit",
    "Limits",
    "MeasureError",
    "MiniProfText",
    "Mounting",
    "Profile",
    "ProfileTextInvalid",
    "Quantity",
    "Reading",
    "ReferenceInvalid",
    "ReferenceProfile",
    "ReferenceUnknown",
    "Status",
    "WheelFrame",
    "WheelQuality",
    "WheelReadings",
    "each_wheel",
    "format_miniprof",
    "gauge_profile",
    "group_into_wheels",
    "measure_wheel",
    "parse_miniprof",
    "parse_profile_csv",
    "parse_profile_text",
    "reference_profile",
]
