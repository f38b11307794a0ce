"""What the station does when asked: passes, calibration sessions, calibrations, jobs.

No HTTP and no process in here: each operation takes the parts of the station it works with.
"""

from station.operations.calibration_pictures import (
    FramePlace,
    pictures_of,
    rig_pictures_of,
)
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
from station.operations.downloads import recording_file
from station.operations.frames import frames_page
from station.operations.guiding import Guiding
from station.operations.keys import Keys, key_id_of
from station.operations.layout import DataLayout
from station.operations.lifetimes import Lifetimes
from station.operations.passes import Passes
from station.operations.recalibrations import (
    RecalibrationOrder,
    add_recalibration,
    answer_recalibration,
    bring_into_force,
    last_good_check,
    order_recalibration,
    supersede_asking,
)
from station.operations.recorded_events import ListedEvent, events_page
from station.operations.refusing import refuse_calibration, refuse_rig_calibration
from station.operations.replays import (
    ReferenceName,
    ReplayOrder,
    ReplayView,
    order_replay,
    replay_view,
)
from station.operations.rigs import (
    RigCalibrationOrder,
    activate_rig_calibration,
    active_rig_calibration,
    keep_rig_calibration,
    order_rig_calibration,
    rig_calibration_points,
)
from station.operations.salvage import salvage_recording
from station.operations.sensors import rig_at, sensor_at, sensor_given
from station.operations.session_orders import SessionOrder, SessionView
from station.operations.sessions import Sessions
from station.operations.shifts import CalibrationShifts, ShiftOfReading
from station.operations.showing import Showing, Shown
from station.operations.triggering import by_command, trigger_pass
from station.operations.uploads import Upload, Uploads
from station.operations.views import PassView, PassWheels

__all__ = [
    "CalibrationOrder",
    "CalibrationShifts",
    "Capture",
    "DataLayout",
    "Guiding",
    "FramePlace",
    "JobQueue",
    "Keys",
    "MethodName",
    "Lifetimes",
    "ListedEvent",
    "PassView",
    "PassWheels",
    "Passes",
    "RecalibrationOrder",
    "ReferenceName",
    "ReplayOrder",
    "ReplayView",
    "RigCalibrationOrder",
    "Salvage",
    "Salvaged",
    "SessionOrder",
    "SessionView",
    "Sessions",
    "ShiftOfReading",
    "Showing",
    "Shown",
    "Station",
    "Upload",
    "Uploads",
    "activate_calibration",
    "activate_rig_calibration",
    "active_calibration",
    "active_rig_calibration",
    "add_recalibration",
    "answer_recalibration",
    "bring_into_force",
    "by_command",
    "calibration_points",
    "cancel_job",
    "events_page",
    "frames_page",
    "keep_rig_calibration",
    "key_id_of",
    "last_good_check",
    "order_calibration",
    "order_recalibration",
    "order_replay",
    "order_rig_calibration",
    "pictures_of",
    "recording_file",
    "refuse_calibration",
    "refuse_rig_calibration",
    "replay_view",
    "rig_at",
    "rig_calibration_points",
    "rig_pictures_of",
    "salvage_recording",
    "sensor_at",
    "sensor_given",
    "supersede_asking",
    "trigger_pass",
    "utc_now",
]
