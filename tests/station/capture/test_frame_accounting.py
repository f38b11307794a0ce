"""Frames are accounted for by their ids: recorded + lost + refused is what was exposed."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from station.capture.accounting import FrameAccount
from station.recording import EventKind, id_after

LOST, REFUSED = "lost", "refused"


@pytest.fixture
def account():
    events = []
    account = FrameAccount(lambda: 1, events.append)
    return account, events


def kinds(events):
    return [event.kind for event in events]


def test_frames_in_order_need_no_event(account):
    counts, events = account
    assert all(counts.arrive(number, None) for number in range(1, 100))
    assert (counts.arrived, counts.lost, events) == (99, 0, [])


def test_gap_is_a_loss_that_names_its_frames(account):
    counts, events = account
    counts.arrive(1, None)
    counts.arrive(5, None)
    assert counts.lost == 3
    (event,) = events
    assert (event.kind, event.frame_id, event.count) == (EventKind.FRAMES_LOST, 2, 3)


def test_first_frame_lost_shows_because_ids_begin_at_one(account):
    counts, events = account
    counts.arrive(3, None)
    assert (counts.lost, events[0].frame_id, events[0].count) == (2, 1, 2)


def test_counter_that_began_long_before_is_no_loss_but_is_said(account):
    counts, events = account
    assert counts.arrive(40_000, None)
    assert (counts.lost, kinds(events)) == (0, [EventKind.COUNTER_OFFSET])


def test_wrap_around_is_no_loss(account):
    counts, events = account
    counts.arrive(65_534, None)
    events.clear()
    assert all(counts.arrive(number, None) for number in (65_535, 1, 2))
    assert (counts.lost, events) == (0, [])


@pytest.mark.parametrize("again", [4, 5])
def test_repeated_or_backward_frame_is_refused_and_said(account, again):
    counts, events = account
    for number in range(1, 6):
        counts.arrive(number, None)
    assert not counts.arrive(again, None)
    assert counts.arrive(6, None)
    assert (counts.repeated, counts.arrived) == (1, 6)
    assert kinds(events) == [EventKind.FRAME_REPEATED]


def test_incomplete_frame_is_refused_and_says_why(account):
    counts, events = account
    counts.arrive(1, None)
    assert not counts.arrive(2, "missing packets")
    assert counts.arrive(3, None)
    assert (counts.arrived, counts.refused, counts.lost) == (2, 1, 0)
    assert (events[0].kind, events[0].detail) == (EventKind.FRAME_REFUSED, "missing packets")


def test_incomplete_frame_without_id_is_counted_once(account):
    counts, events = account
    counts.arrive(1, None)
    assert not counts.arrive(None, "timeout")
    assert counts.arrive(3, None)
    assert (counts.refused, counts.lost) == (0, 1)
    assert kinds(events) == [EventKind.FRAME_REFUSED, EventKind.FRAMES_LOST]


def test_frames_that_could_not_be_written_are_one_event(account):
    counts, events = account
    for number in range(1, 6):
        counts.arrive(number, None)
    for number in (3, 4, 5):
        counts.drop(number)
    counts.close(triggered=5)
    assert (counts.arrived, counts.lost) == (2, 3)
    (event,) = events
    assert (event.kind, event.frame_id, event.count) == (EventKind.FRAMES_DROPPED, 3, 3)


def test_last_frame_lost_shows_in_the_count_of_triggers(account):
    counts, events = account
    counts.arrive(1, None)
    counts.close(triggered=3)
    assert counts.lost == 2
    assert (events[0].kind, events[0].count) == (EventKind.FRAMES_MISCOUNTED, 2)


def test_more_frames_than_triggers_is_unexplained(account):
    counts, events = account
    counts.arrive(1, None)
    counts.arrive(2, None)
    counts.close(triggered=1)
    assert (counts.lost, kinds(events)) == (0, [EventKind.FRAMES_MISCOUNTED])


def test_camera_opened_again_begins_to_count_anew(account):
    counts, events = account
    counts.arrive(7, None)
    events.clear()
    counts.begin_again()
    assert counts.arrive(1, None)
    assert events == []


def test_frames_of_a_camera_opened_again_are_numbered_on(account):
    counts, events = account
    counts.arrive(7, None)
    for _ in range(2):
        counts.begin_again()
    counts.arrive(1, None)
    counts.arrive(3, "timeout")
    assert [counts.number(one) for one in (1, 2, 3)] == [8, 9, 10]
    lost, refused = events[-2:]
    assert (lost.frame_id, refused.frame_id) == (9, 10)
    counts.begin_again()
    assert counts.number(1) == 11


def test_numbers_of_a_camera_opened_again_wrap_as_its_ids_do(account):
    counts, _ = account
    counts.arrive(65534, None)
    counts.begin_again()
    assert [counts.number(one) for one in (1, 2)] == [65535, 1]


def test_numbers_of_64_bits_go_on_where_they_were(account):
    counts, _ = account
    counts.arrive(2**33, None)
    counts.begin_again()
    assert counts.number(1) == 2**33 + 1


@given(st.integers(1, 900), st.lists(st.sampled_from(["whole", LOST, REFUSED]), max_size=60))
def test_the_account_always_adds_up(first, fates):
    events = []
    account = FrameAccount(lambda: 1, events.append)
    for steps, fate in enumerate(fates, first):
        if fate != LOST:
            account.arrive(id_after(1, steps), None if fate == "whole" else "timeout")
    account.close(triggered=first + len(fates))
    assert account.refused == fates.count(REFUSED)
    assert account.arrived == fates.count("whole")
    assert account.arrived + account.lost + account.refused == first + len(fates)
    counted = {EventKind.FRAMES_LOST, EventKind.FRAMES_MISCOUNTED}
    assert sum(event.count for event in events if event.kind in counted) == account.lost
