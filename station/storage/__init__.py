"""The disk: space before a recording begins, recordings that make way, and smaller ones."""

from station.storage.compacting import CompactedFiles, compact_measured
from station.storage.retention import Candidate, Deletion, Usage, to_delete
from station.storage.space import (
    GB,
    Expected,
    ensure_space,
    expected_of_pass,
    expected_of_session,
    free_bytes,
)
from station.storage.tidying import tidy

__all__ = [
    "GB",
    "Candidate",
    "CompactedFiles",
    "Deletion",
    "Expected",
    "Usage",
    "compact_measured",
    "ensure_space",
    "expected_of_pass",
    "expected_of_session",
    "free_bytes",
    "tidy",
    "to_delete",
]
