"""How frame ids follow one another, with wrap-around and 64-bit ids."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from station.recording import id_after, ids_skipped

ids = st.integers(1, 65535)


@given(ids, st.integers(1, 30_000))
def test_id_so_many_later_leaves_one_less_between(first, steps):
    assert ids_skipped(first, id_after(first, steps)) == steps - 1


@given(ids, st.integers(1, 30_000))
def test_id_that_runs_backward_is_not_ahead(first, steps):
    assert ids_skipped(id_after(first, steps), first) is None


@given(ids)
def test_id_never_becomes_zero(first):
    assert 1 <= id_after(first) <= 65535


@pytest.mark.parametrize(
    ("previous", "current", "skipped"),
    [(65535, 1, 0), (65534, 1, 1), (65535, 65536, 0), (70_000, 70_003, 2), (70_003, 70_000, None)],
)
def test_both_kinds_of_ids_end_where_they_do(previous, current, skipped):
    assert ids_skipped(previous, current) == skipped
