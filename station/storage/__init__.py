"""The disk: space before a recording begins, recordings that make way, and smaller ones."""

from station.storage.compacting import CompactedFiles, compact_recording, due_for_compacting
from station.storage.retention import Candidate, Deletion, Usage, to_delete
from station.storage.space import (
    GB,
    Expected,
    ensure_space,
    expected_of_pass,
    expected_of_session,
    free_bytes,
)
from station.storage.tidying import (
    due_deletions,
    files_of_recording,
    next_to_go,
    recordings_bytes,
    tidy,
)
from station.storage.unnamed import unnamed_recordings

__all__ = [
    "GB",
    "Candidate",
    "CompactedFiles",
    "Deletion",
    "Expected",
    "Usage",
    "compact_recording",
    "due_deletions",
    "due_for_compacting",
    "ensure_space",
    "expected_of_pass",
    "expected_of_session",
    "files_of_recording",
    "free_bytes",
    "next_to_go",
    "recordings_bytes",
    "tidy",
    "to_delete",
    "unnamed_recordings",
]
