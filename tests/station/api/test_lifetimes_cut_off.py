"""Shows that a pass ends, and nothing it recorded is lost, wherever the API process dies: after
each of the deeds that outlast it, in turn.  The sensors are doubles that keep true files."""

from contextlib import suppress
from itertools import count

import pytest
from mortal import Died, Life, mortal
from trackside import Trackside, frames_in

from station.operations import Lifetimes, Passes, Sessions
from station.store import HELD, Actor, Pass, Recording, the

BY = Actor("plc")


class Ground(Trackside):
    """The doubles alone: what would be called over HTTP is called at the desk."""

    def begin(self):
        """Serve nothing."""

    def end(self):
        """Nothing was served."""

    def desk_that_dies_after(self, deeds):
        life = Life()
        life.end_after(deeds)
        return Passes(mortal(self.station, life)), life

    def start_again(self):
        """Do what a new API process does, and then nothing but look, for an hour."""
        passes, sessions = Passes(self.station), Sessions(self.station)
        passes.take_up()
        sessions.take_up()
        times_s = [0.0, 1.0, 3600.0, 3601.0]
        lifetimes = Lifetimes(self.station, passes, sessions, lambda: times_s[0])
        while times_s:
            lifetimes.look()
            times_s.pop(0)

    def train(self):
        for capture in self.captures.values():
            capture.wheel()


def by_opening(desk):
    desk.open("p1", train=None, by=BY)


def by_finishing(desk):
    desk.finish("p1", axles=2, triggers={}, by=BY)


def by_time(desk):
    desk.end_overdue("p1", "no finish came")


def by_taking_up(desk):
    desk.take_up()


CUTS = {
    "opening": (None, by_opening),
    "finishing": ("recording", by_finishing),
    "ending by itself": ("recording", by_time),
    "taking up what was recorded": ("left behind", by_taking_up),
    "taking up what was armed": ("half armed", by_taking_up),
}


def bring(ground, standing):
    """Bring a pass to where the call that dies finds it."""
    if standing is None:
        return
    desk = Passes(ground.station)
    if standing == "half armed":
        dying, _ = ground.desk_that_dies_after(2)
        with suppress(Died):
            by_opening(dying)
        return
    by_opening(desk)
    ground.train()
    if standing == "left behind":
        for capture in ground.captures.values():
            capture.die()


@pytest.mark.parametrize("cut", CUTS)
def test_a_pass_ends_wherever_the_process_dies(tmp_path, empty_store, cut):
    standing, call = CUTS[cut]
    for deeds in count(1):
        root = tmp_path / str(deeds)
        root.mkdir()
        ground = Ground(root, empty_store)
        bring(ground, standing)
        desk, life = ground.desk_that_dies_after(deeds)
        with suppress(Died):
            call(desk)
        ground.train()
        ground.start_again()
        ensure_all_ended(ground)
        ground.store.close()
        if not life.dead:
            break
    assert deeds > 1


def ensure_all_ended(ground):
    with ground.store.look() as session:
        assert the(session, Pass, "p1").state not in HELD
        rows = session.query(Recording).all()
    assert all(capture.plan is None for capture in ground.captures.values())
    kept = {file: frames_in(file) for file in ground.layout.root.rglob("*.mcap*")}
    listed = {ground.layout.root / row.path: row.recorded for row in rows if row.files}
    assert kept == listed
    _, new = Passes(ground.station).open("p2", train=None, by=BY)
    assert new
