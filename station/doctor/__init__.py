"""What on this host would lose frames or data, and the cure."""

from station.doctor.checkup import Checkup, Examination, examine_apart
from station.doctor.examine import Patient, examine
from station.doctor.finding import Finding

__all__ = ["Checkup", "Examination", "Finding", "Patient", "examine", "examine_apart"]
