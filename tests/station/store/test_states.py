"""Shows that the tables of states hold and are refused by name.  That every operation asks them is
shown with the API."""

import pytest

from station.errors import StateConflict
from station.store import CALIBRATION, JOB, PASS, SESSION, PassState


def test_a_pass_goes_its_way_from_armed_to_done():
    way = ["armed", "recording", "recorded", "measuring", "done"]
    for present, wanted in zip(way, way[1:], strict=False):
        PASS.check("p1", PassState(present), PassState(wanted))


ALLOWED = {
    ("armed", "recording"),
    ("armed", "recorded"),
    ("armed", "failed"),
    ("recording", "recorded"),
    ("recording", "failed"),
    ("recorded", "measuring"),
    ("recorded", "done"),
    ("recorded", "failed"),
    ("measuring", "done"),
    ("measuring", "recovered"),
    ("measuring", "failed"),
    ("measuring", "recorded"),
    ("failed", "armed"),
}


@pytest.mark.parametrize("present", PassState)
@pytest.mark.parametrize("wanted", PassState)
def test_every_other_step_of_a_pass_is_refused_and_names_the_present_state(present, wanted):
    if (present.value, wanted.value) in ALLOWED:
        PASS.check("p1", present, wanted)
        return
    with pytest.raises(StateConflict, match=f"pass p1 is {present}") as refusal:
        PASS.check("p1", present, wanted)
    assert refusal.value.state == present


@pytest.mark.parametrize("table", [PASS, SESSION, CALIBRATION, JOB])
def test_every_state_is_in_the_table_and_can_end(table):
    states = set(type(next(iter(table.allowed))))
    assert set(table.allowed) == states
    ends = {state for state in states if table.ended(state)}
    reached = set(ends)
    for _ in states:
        reached |= {state for state in states if table.allowed[state] & reached}
    assert reached == states
    assert set(table.unfinished) == states - ends
