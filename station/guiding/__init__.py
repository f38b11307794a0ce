"""Guiding who takes calibration pictures: what each shows, what is enough, what comes next.

Finding a target takes tenths of a second a picture and a trial solve a second, during which the
process that answers calls would keep its callers waiting, and the viewing process the live
pictures of all sensors.  So a process of its own does it, behind everything that records or
measures; it is started when somebody calibrates and ends a minute after.
"""

from station.guiding.enough import Criterion, Demands
from station.guiding.guidance import Guidance, PoseSeen, Wanted
from station.guiding.guide import Guide, GuideLost
from station.guiding.watch import SessionSoFar, SessionWatch

__all__ = [
    "Criterion",
    "Demands",
    "Guidance",
    "Guide",
    "GuideLost",
    "PoseSeen",
    "SessionSoFar",
    "SessionWatch",
    "Wanted",
]
