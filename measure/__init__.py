"""From a stripe on a wheel to gauge readings with their uncertainty.  Pure mathematics, mm."""

from measure.errors import MeasureError, ProfileTextInvalid, ReferenceInvalid, ReferenceUnknown
from measure.quantities import Alarm, Quantity, Reading, Status
from measure.reference import ReferenceProfile, reference_profile

__all__ = [
    "Alarm",
    "MeasureError",
    "ProfileTextInvalid",
    "Quantity",
    "Reading",
    "ReferenceInvalid",
    "ReferenceProfile",
    "ReferenceUnknown",
    "Status",
    "reference_profile",
]
