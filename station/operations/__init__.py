"""What the station does when asked: passes, calibration sessions, calibrations, jobs.

No HTTP and no process in here: each operation takes the parts of the station it works with.
"""

from station.operations.calibrations import (
    CalibrationOrder,
    MethodName,
    activate_calibration,
    active_calibration,
    calibration_points,
    order_calibration,
)
from station.operations.cancelling import cancel_job
from station.operations.collaborators import (
    Capture,
    JobQueue,
    Salvage,
    Salvaged,
    Station,
    utc_now,
)
from station.operations.layout import DataLayout
from station.operations.passes import Passes, PassView, PassWheels
from station.operations.salvage import salvage_recording
from station.operations.sessions import Sessions, SessionView

__all__ = [
    "CalibrationOrder",
    "Capture",
    "DataLayout",
    "JobQueue",
    "MethodName",
    "PassView",
    "PassWheels",
    "Passes",
    "Salvage",
    "Salvaged",
    "SessionView",
    "Sessions",
    "Station",
    "activate_calibration",
    "active_calibration",
    "calibration_points",
    "cancel_job",
    "order_calibration",
    "salvage_recording",
    "utc_now",
]
