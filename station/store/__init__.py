"""What the station knows, in a database: SQLite by default, any that SQLAlchemy speaks by URL.

Two ways in: ``with store.change() as session`` writes all or nothing, ``with store.look() as
session`` reads one moment.  The functions here take such a session.
"""

from station.store.activations import activate, active
from station.store.disposal import disposable_recordings, measured_recordings
from station.store.engine import Store, sqlite_url
from station.store.jobs import (
    JobKind,
    add_job,
    end,
    report_progress,
    start,
    unfinished_jobs,
)
from station.store.keys import (
    Caller,
    Scope,
    add_key,
    any_key,
    caller_of,
    digest,
    ensure_unguessable,
)
from station.store.lookups import (
    Page,
    counts_by_state,
    frame_totals,
    measurements_page,
    open_sessions,
    pass_in_progress,
    recordings_of,
    recordings_page,
    session_in_progress,
    the,
    unfinished_passes,
    wheels_of,
)
from station.store.measurements import add_measurements
from station.store.migrate import EMPTY, NEWEST, migrate, revision_of
from station.store.states import (
    CALIBRATION,
    JOB,
    PASS,
    SESSION,
    CalibrationState,
    JobState,
    PassState,
    SessionState,
    Transitions,
)
from station.store.tables import (
    Activation,
    Calibration,
    CalibrationPoints,
    CalibrationSession,
    Job,
    JsonObject,
    Measurement,
    Pass,
    Recording,
    Table,
)

__all__ = [
    "CALIBRATION",
    "EMPTY",
    "JOB",
    "NEWEST",
    "PASS",
    "SESSION",
    "Activation",
    "Calibration",
    "CalibrationPoints",
    "CalibrationSession",
    "CalibrationState",
    "Caller",
    "Job",
    "JobKind",
    "JobState",
    "JsonObject",
    "Measurement",
    "Page",
    "Pass",
    "PassState",
    "Recording",
    "Scope",
    "SessionState",
    "Store",
    "Table",
    "Transitions",
    "activate",
    "active",
    "add_job",
    "add_key",
    "add_measurements",
    "any_key",
    "caller_of",
    "counts_by_state",
    "digest",
    "disposable_recordings",
    "frame_totals",
    "end",
    "ensure_unguessable",
    "measured_recordings",
    "measurements_page",
    "migrate",
    "open_sessions",
    "pass_in_progress",
    "recordings_of",
    "recordings_page",
    "report_progress",
    "revision_of",
    "session_in_progress",
    "sqlite_url",
    "start",
    "the",
    "unfinished_jobs",
    "unfinished_passes",
    "wheels_of",
]
