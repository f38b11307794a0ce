"""What makes way: measured recordings, the oldest first, only as many as must."""

from datetime import UTC, datetime, timedelta

import pytest

from station.settings import StorageSettings
from station.storage import Candidate, Usage, to_delete

NOW = datetime(2026, 7, 1, 12, tzinfo=UTC)
GB = 10**9


def candidates(*ages_days, size_bytes=GB):
    return [Candidate(f"r{age}", NOW - timedelta(days=age), size_bytes) for age in ages_days]


def deleted(settings, usage, *ages_days):
    gone = to_delete(candidates(*ages_days), usage, settings, NOW)
    return [each.candidate.recording_id for each in gone]


ROOMY = Usage(recordings_bytes=10 * GB, free_bytes=100 * GB)


def test_nothing_goes_without_a_limit_however_full_the_disk_is():
    settings = StorageSettings(keep_free_gb=5.0)
    assert deleted(settings, Usage(10 * GB, 0), 1, 2, 3) == []


def test_oldest_go_until_the_quota_is_kept_and_no_more():
    settings = StorageSettings(quota_gb=8.0)
    assert deleted(settings, ROOMY, 1, 5, 3, 4) == ["r5", "r4"]
    assert deleted(StorageSettings(quota_gb=10.0), ROOMY, 1, 5) == []


def test_old_ones_go_by_age():
    assert deleted(StorageSettings(keep_days=3.5), ROOMY, 1, 5, 3, 4) == ["r5", "r4"]


def test_oldest_go_for_the_space_that_is_to_stay_free():
    settings = StorageSettings(quota_gb=1000.0, keep_free_gb=3.0)
    assert deleted(settings, Usage(10 * GB, GB), 1, 5, 3, 4) == ["r5", "r4"]


def test_quota_that_cannot_be_kept_takes_what_may_go_and_ends():
    assert deleted(StorageSettings(quota_gb=1.0), ROOMY, 2, 1) == ["r2", "r1"]


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (StorageSettings(quota_gb=9.5), "10.00 GB of recordings, quota_gb = 9.5"),
        (StorageSettings(keep_days=1.0), "older than keep_days = 1"),
        (StorageSettings(keep_days=90.0, keep_free_gb=101.0), "100.00 GB free, keep_free_gb = 101"),
    ],
)
def test_reason_names_the_limit_and_the_figure(settings, said):
    (first, *_) = to_delete(candidates(2), ROOMY, settings, NOW)
    assert first.why == said
