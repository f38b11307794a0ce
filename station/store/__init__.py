"""What the station knows, in a database: SQLite by default, PostgreSQL by URL.

Two ways in: ``with store.change() as session`` writes all or nothing, ``with store.look() as
session`` reads one moment.  The functions here take such a session.

Here is what nearly everybody asks: the store, its tables and states, rows by their ids, what is in
force, what holds the sensors, jobs and the trail.  The rest has doors of its own, which none of
these knows::

    callers            who may call, and what was answered
    lists              what there is of each kind, page by page
    measured           wheels, their profiles and axles
    changes            what the fleet has not been told yet
    disposal           which recordings may go from the disk
    recalibrations     how recalibrations of a sensor stand
    recordings_found   recordings by what they were made for, and what was measured from them
    watched            what tells how the station is
"""

from station.store.activations import activate, activate_rig, activation_of, active, active_rig
from station.store.audit import STATION, Action, Actor, audit
from station.store.connecting import database_url, looking, sqlite_engine
from station.store.engine import Store, sqlite_url
from station.store.held import (
    HELD,
    open_sessions,
    pass_in_progress,
    passes_held,
    paths_being_recorded,
    session_in_progress,
)
from station.store.integrity import ensure_sound, file_of
from station.store.jobs import JobKind, add_job, end, report_progress, start, unfinished_jobs
from station.store.lookups import recordings_of, the
from station.store.migrate import EMPTY, NEWEST, ensure_known, migrate, revision_of
from station.store.revisions import Revision, Revisions
from station.store.states import (
    CALIBRATION,
    JOB,
    PASS,
    RECALIBRATION,
    SESSION,
    CalibrationState,
    EndedBy,
    JobState,
    PassState,
    RecalibrationState,
    SessionState,
    Transitions,
)
from station.store.tables import (
    Activation,
    AuditEntry,
    AxleWheel,
    Calibration,
    CalibrationPoints,
    CalibrationSession,
    Change,
    EarlyReading,
    Following,
    Job,
    JsonObject,
    KeptAnswer,
    KeptPieceCheck,
    Key,
    Login,
    Measurement,
    MeasurementProfile,
    Pass,
    Push,
    Recalibration,
    Recording,
    Replay,
    ReplayMeasurement,
    RigActivation,
    RigCalibration,
    RigCalibrationPoints,
    StoreEpoch,
    Table,
    UtcDateTime,
)
from station.store.touched import tables_read

__all__ = [
    "Action",
    "Activation",
    "Actor",
    "AuditEntry",
    "AxleWheel",
    "CALIBRATION",
    "Calibration",
    "CalibrationPoints",
    "CalibrationSession",
    "CalibrationState",
    "Change",
    "EMPTY",
    "EarlyReading",
    "EndedBy",
    "Following",
    "HELD",
    "JOB",
    "Job",
    "JobKind",
    "JobState",
    "JsonObject",
    "KeptAnswer",
    "KeptPieceCheck",
    "Key",
    "Login",
    "Measurement",
    "MeasurementProfile",
    "NEWEST",
    "PASS",
    "Pass",
    "PassState",
    "Push",
    "RECALIBRATION",
    "Recalibration",
    "RecalibrationState",
    "Recording",
    "Replay",
    "ReplayMeasurement",
    "Revision",
    "Revisions",
    "RigActivation",
    "RigCalibration",
    "RigCalibrationPoints",
    "SESSION",
    "STATION",
    "SessionState",
    "Store",
    "StoreEpoch",
    "Table",
    "Transitions",
    "UtcDateTime",
    "activate",
    "activate_rig",
    "activation_of",
    "active",
    "active_rig",
    "add_job",
    "audit",
    "database_url",
    "end",
    "ensure_known",
    "ensure_sound",
    "file_of",
    "looking",
    "migrate",
    "open_sessions",
    "pass_in_progress",
    "passes_held",
    "paths_being_recorded",
    "recordings_of",
    "report_progress",
    "revision_of",
    "session_in_progress",
    "sqlite_engine",
    "sqlite_url",
    "start",
    "tables_read",
    "the",
    "unfinished_jobs",
]
