"""How the station is: its parts, and what somebody should look at.

One look serves `/readyz`, `/metrics` and the alarms of `/v1/station`, so that they never differ.
"""

from station.watching.asking import Asker, answers_of
from station.watching.lookout import Lookout
from station.watching.outlook import Condition, Outlook, PartState
from station.watching.troubles import Severity, Trouble, TroubleKind, part_of_sensor

__all__ = [
    "Asker",
    "answers_of",
    "Lookout",
    "Outlook",
    "PartState",
    "Condition",
    "Severity",
    "Trouble",
    "TroubleKind",
    "part_of_sensor",
]
