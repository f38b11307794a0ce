"""Copies of the store that outlive its disk: made while the station runs, brought back while not.

The store has everything but the recordings: calibrations, readings, jobs, keys, the audit trail.
"""

from station.backups.making import Backup, make_backup
from station.backups.restoring import Restored, restore_backup
from station.backups.series import drop_all_but, next_in
from station.backups.way_back import newest_restorable

__all__ = [
    "Backup",
    "Restored",
    "drop_all_but",
    "make_backup",
    "newest_restorable",
    "next_in",
    "restore_backup",
]
