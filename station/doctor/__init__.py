"""What on this host would lose frames or data, and the cure."""

from station.doctor.examine import Patient, examine
from station.doctor.finding import Finding

__all__ = ["Finding", "Patient", "examine"]
