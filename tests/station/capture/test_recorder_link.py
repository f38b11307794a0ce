"""The capture process's side of its recorder: what was written is counted once, whoever dies."""

import os
import signal
import time

import numpy as np
import pytest
from capture_rig import served_pictures

from station.capture.intake import Intake
from station.capture.link import FrameEntry, RecorderDied, RecorderLink
from station.capture.plan import RecordingPlan
from station.capture.ring import Ring
from station.errors import InputUnusable
from station.recording import Event, EventKind, active_path, events, frames, verify

WIDTH, HEIGHT = 64, 48


@pytest.fixture
def ring():
    ring = Ring.create(8, WIDTH * HEIGHT)
    for slot, pixels in enumerate(served_pictures(WIDTH, HEIGHT, 8)):
        ring.picture(slot, WIDTH * HEIGHT)[:] = pixels.data.cast("B")
    yield ring
    ring.close()


@pytest.fixture
def link(ring):
    link = RecorderLink(ring)
    yield link
    link.close()


@pytest.fixture
def plan(tmp_path):
    return RecordingPlan("x", tmp_path / "a.mcap", "left")


def entry(slot):
    return FrameEntry(slot, slot + 1, 1000 + slot, 2000 + slot, WIDTH, HEIGHT)


def all_outcomes(link):
    found = []
    while link.pending:
        found += link.outcomes(timeout_s=5.0)
    return found


def put_and_wait(link, each):
    link.put(each)
    return all_outcomes(link)


def test_entries_are_answered_in_their_order_once_they_are_in_the_file(link, plan):
    link.open(plan, {})
    entries = [Event(EventKind.STARTED, 1), *(entry(slot) for slot in range(8))]
    for each in entries:
        link.put(each)
    outcomes = all_outcomes(link)
    assert [outcome.entry for outcome in outcomes] == entries
    assert all(outcome.failure is None for outcome in outcomes)
    assert link.finish({"recorded": "8"}) == 8
    for frame, pixels in zip(frames(plan.path), served_pictures(WIDTH, HEIGHT, 8), strict=True):
        np.testing.assert_array_equal(frame.picture, pixels)


def test_frames_written_but_not_yet_answered_are_not_written_twice(link, plan):
    link.open(plan, {})
    link.put(Event(EventKind.STARTED, 1))
    for slot in range(3):
        link.put(entry(slot))
    time.sleep(0.3)  # the recorder writes them; nobody reads its answers
    os.kill(link.pid, signal.SIGSTOP)
    for slot in range(3, 8):
        link.put(entry(slot))
    os.kill(link.pid, signal.SIGKILL)
    unsaid = link.restart()
    assert [outcome.entry for outcome in unsaid] == [
        Event(EventKind.STARTED, 1),
        *(entry(slot) for slot in range(3)),
    ]
    assert [outcome.entry for outcome in all_outcomes(link)] == [entry(n) for n in range(3, 8)]
    assert link.finish({}) == 8
    assert [frame.frame_id for frame in frames(plan.path)] == list(range(1, 9))
    assert len(events(plan.path)) == 1
    assert verify(plan.path).ok


def test_dead_recorder_is_noticed_when_it_is_asked(link, plan):
    link.open(plan, {})
    os.kill(link.pid, signal.SIGKILL)
    with pytest.raises(RecorderDied):
        put_and_wait(link, entry(0))


def test_refusal_of_the_recorder_comes_as_the_stations_error(link, plan):
    plan.path.write_bytes(b"precious")
    with pytest.raises(InputUnusable, match="exists"):
        link.open(plan, {})
    assert not link.is_recording


def test_recording_taken_back_leaves_nothing(link, plan):
    link.open(plan, {})
    assert active_path(plan.path).exists()
    link.discard()
    assert list(plan.path.parent.iterdir()) == []


def test_frames_given_up_for_the_end_of_the_file_are_not_counted_as_recorded(link):
    intake = Intake(link, range(8), limit=None)
    for number in range(1, 6):
        intake.account.arrive(number, None)
        intake.account.confirm()
    intake.compare(frames=3)
    assert (intake.account.recorded, intake.account.lost, intake.account.accounted) == (3, 2, 5)
    assert [(event.kind, event.count) for event in intake.events] == [(EventKind.FRAMES_DROPPED, 2)]


def kill(link):
    os.kill(link.pid, signal.SIGKILL)
    os.waitid(os.P_PID, link.pid, os.WEXITED | os.WNOWAIT)


def test_recorder_that_died_with_nothing_to_do_is_followed_by_another_at_once(link):
    link.ensure_alive()
    first = link.pid
    kill(link)
    link.ensure_alive()
    assert link.pid != first


@pytest.mark.parametrize("begun", [False, True])
def test_recorder_killed_while_it_opens_a_recording_is_followed_by_one_that_does(
    link, plan, monkeypatch, begun
):
    first, ask = link.pid, link._ask

    def ask_and_die(order, timeout_s):
        monkeypatch.setattr(link, "_ask", ask)
        if begun:
            ask(order, timeout_s)
        kill(link)
        return ask(order, timeout_s)

    monkeypatch.setattr(link, "_ask", ask_and_die)
    link.open(plan, {"session": {"id": "x"}})
    assert link.pid != first
    assert put_and_wait(link, entry(0))[0].failure is None
    assert link.finish({}) == 1
    assert verify(plan.path).ok


def test_recording_whose_recorder_finished_it_and_died_before_it_said_so_is_finished(link, plan):
    link.open(plan, {})
    put_and_wait(link, entry(0))
    assert link.finished_unsaid() is None
    link._send({"do": "finish", "accounting": {"recorded": "1"}})
    assert link._has_answer(20.0)
    kill(link)
    assert link.finished_unsaid() == 1
    assert link.paths == (plan.path,)
    assert not link.is_recording
