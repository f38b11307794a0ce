"""Copies of the store that outlive its disk: made while the station runs, brought back while not.

The store has everything but the recordings: calibrations, readings, jobs, keys, the audit trail.
"""

from station.backups.making import Backup, make_backup
from station.backups.restoring import Restored, restore_backup

__all__ = ["Backup", "Restored", "make_backup", "restore_backup"]
