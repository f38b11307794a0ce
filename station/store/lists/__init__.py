"""What the station has of each kind, page by page."""

from station.store.lists.calibrations import (
    activations_page,
    calibrations_page,
    rig_activations_page,
    rig_calibrations_page,
)
from station.store.lists.jobs import jobs_page, recalibrations_page, replays_page
from station.store.lists.measurements import measurements_page
from station.store.lists.paging import ALWAYS, Cursor, Page, Span, newest_page
from station.store.lists.recorded import (
    passes_page,
    recordings_by_pass,
    recordings_by_session,
    recordings_page,
    sessions_page,
)
from station.store.lists.trail import audit_page

__all__ = [
    "ALWAYS",
    "Cursor",
    "Page",
    "Span",
    "activations_page",
    "audit_page",
    "calibrations_page",
    "jobs_page",
    "measurements_page",
    "newest_page",
    "passes_page",
    "recalibrations_page",
    "recordings_by_pass",
    "recordings_by_session",
    "recordings_page",
    "replays_page",
    "rig_activations_page",
    "rig_calibrations_page",
    "sessions_page",
]
