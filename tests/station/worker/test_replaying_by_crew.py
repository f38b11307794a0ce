"""A replay of many recordings is done by a crew: workers of the site's cluster or of this machine.

What is measured is told by a double; that workers read as a pass was read is shown with replaying.
"""

from contextlib import nullcontext
from dataclasses import replace

import pytest
from dask_site import configured_for
from test_replaying import add_calibration, order, rows
from worker_double import WHEELS, SlowMathematics

import station.replay.cluster as replay_cluster
import station.worker.replaying as replaying
from station.errors import InputUnusable
from station.operations import cancel_job, replay_view
from station.replay import Here, local_workers, workers_at
from station.settings import ReplaySettings
from station.store import Actor, Replay, the
from station.worker.context import WorkContext
from station.worker.replaying import begin_replay, conclude_replay, replay_step

BOTH = {"left": "of-left", "right": "of-right"}
NOWHERE = "tcp://127.72.1.1:9"


@pytest.fixture(scope="module")
def crew():
    with local_workers(1) as workers:
        yield workers


@pytest.fixture
def site(crew, tmp_path):
    """The address of a cluster, and Dask configured as on its site."""
    with configured_for(crew, tmp_path) as address:
        yield address


@pytest.fixture
def context(ground, tmp_path):
    mathematics = SlowMathematics(tmp_path / "trace", step_s=0.0)
    return WorkContext(ground.settings, ground.store, ground.layout, mathematics.parts)


def on_cluster(context, address):
    replay = ReplaySettings(cluster=address)
    return replace(context, settings=context.settings.model_copy(update={"replay": replay}))


def did(tmp_path):
    return sorted((tmp_path / "trace").read_text().splitlines())


def replayed(context, view):
    for place in range(begin_replay(context, view.job.id)):
        replay_step(context, view.job.id, place)
    conclude_replay(context, view.job.id)
    with context.store.look() as session:
        return replay_view(session, the(session, Replay, view.row.id))


def found_done(step):
    """Stand in for measuring in this process, where a crew has to have done it."""
    assert step._steps[step._place] not in step._left()


ONCE_EACH = [
    "begin measure left",
    "begin measure right",
    "end measure left",
    "end measure right",
]


def test_the_workers_of_the_sites_cluster_measure_each_recording_once(
    ground,
    context,
    station,
    site,
    tmp_path,
    monkeypatch,
):
    monkeypatch.setattr(replaying._Step, "do", found_done)
    ground.order_measuring("p1")
    done = replayed(on_cluster(context, site), order(station, pass_id="p1", calibrations=BOTH))
    assert (done.job.state, done.job.error, done.measurements) == ("done", None, 2 * WHEELS)
    assert did(tmp_path) == ONCE_EACH
    found = rows(ground, replay=done.row.id)
    assert {(row.recording_id, row.calibration_id) for row in found} == {
        ("pass.p1.left", "of-left"),
        ("pass.p1.right", "of-right"),
    }


def test_a_rig_is_measured_by_a_cluster_as_it_is_here(
    ground,
    context,
    station,
    site,
):
    rig = ground.bring_rig_into_force()
    ground.order_measuring("p1", sensors=("inner", "outer"), rig=rig)
    of_rig = {"pass_id": "p1", "rig_calibration": rig}
    there = replayed(on_cluster(context, site), order(station, **of_rig))
    here = replayed(context, order(station, **of_rig))
    assert there.row.results == {"pass.p1.inner": {"wheels": WHEELS, "added": WHEELS}}
    assert here.row.results == {"pass.p1.inner": {"wheels": WHEELS, "added": 0}}


def test_many_steps_are_given_to_workers_of_this_machine(
    ground,
    context,
    station,
    crew,
    tmp_path,
    monkeypatch,
):
    asked = []
    monkeypatch.setattr(replaying._Step, "do", found_done)
    monkeypatch.setattr(replaying, "_STEPS_A_WORKER", 0)
    monkeypatch.setattr(
        replaying, "sooner_by_workers", lambda alone_s, count: not asked.append((alone_s, count))
    )
    monkeypatch.setattr(replaying, "local_workers", lambda _count: nullcontext(crew))
    ground.order_measuring("p1", recorded={"left": 30, "right": 10})
    done = replayed(context, order(station, pass_id="p1", calibrations=BOTH))
    assert done.measurements == 2 * WHEELS
    assert did(tmp_path) == ONCE_EACH
    assert [alone_s for alone_s, _ in asked] == [pytest.approx(40 * replaying.FRAME_S)]


def test_a_cluster_that_does_not_answer_is_one_line_and_the_station_goes_on(
    ground,
    context,
    station,
    tmp_path,
    monkeypatch,
):
    monkeypatch.setattr(replay_cluster, "_CONNECT_S", 1)
    asked = []
    monkeypatch.setattr(
        replaying, "workers_at", lambda address: asked.append(address) or workers_at(address)
    )
    ground.order_measuring("p1")
    done = replayed(on_cluster(context, NOWHERE), order(station, pass_id="p1", calibrations=BOTH))
    assert (done.job.state, done.measurements) == ("done", 2 * WHEELS)
    assert done.job.error.startswith(f"cluster {NOWHERE}: no Dask scheduler answers there")
    assert done.job.error.endswith("; going on with the cores of the station")
    assert asked == [NOWHERE]  # not once more by each step
    assert "\n" not in done.job.error
    assert did(tmp_path) == ONCE_EACH


def test_a_cluster_that_is_lost_in_the_middle_costs_nothing_that_was_kept(
    ground,
    context,
    station,
    tmp_path,
    monkeypatch,
):
    class Lost(Here):
        def each(self, work, tasks, *, meanwhile):
            yield next(super().each(work, tasks, meanwhile=meanwhile))
            raise InputUnusable("the cluster's scheduler is gone")

    monkeypatch.setattr(replaying, "workers_at", lambda _address: nullcontext(Lost()))
    ground.order_measuring("p1")
    done = replayed(on_cluster(context, NOWHERE), order(station, pass_id="p1", calibrations=BOTH))
    assert (done.job.state, done.measurements) == ("done", 2 * WHEELS)
    assert done.job.error.startswith("the cluster's scheduler is gone; going on")
    assert did(tmp_path) == ONCE_EACH


def test_a_station_killed_in_the_middle_has_the_crew_do_what_is_left_and_no_more(
    ground,
    context,
    station,
    tmp_path,
    monkeypatch,
):
    class Killed(BaseException):
        """Not to be caught, as a kill is not."""

    class Cut(Here):
        def each(self, work, tasks, *, meanwhile):
            yield next(super().each(work, tasks, meanwhile=meanwhile))
            raise Killed

    there = on_cluster(context, NOWHERE)
    monkeypatch.setattr(replaying, "workers_at", lambda _address: nullcontext(Cut()))
    ground.order_measuring("p1")
    view = order(station, pass_id="p1", calibrations=BOTH)
    with pytest.raises(Killed):
        replayed(there, view)
    monkeypatch.setattr(replaying, "workers_at", lambda _address: nullcontext(Here()))
    done = replayed(there, view)
    assert (done.job.error, done.measurements) == (None, 2 * WHEELS)
    assert did(tmp_path) == ONCE_EACH


def test_what_a_cluster_cannot_measure_is_named_and_the_others_are_measured(
    ground,
    context,
    station,
    site,
):
    ground.order_measuring("p1", names={"right": "unreadable"})
    done = replayed(on_cluster(context, site), order(station, pass_id="p1", calibrations=BOTH))
    assert (done.job.state, done.measurements) == ("done", WHEELS)
    assert done.job.error == "pass.p1.right: RuntimeError: a fault nobody foresaw"


def test_a_replay_cancelled_while_a_cluster_works_keeps_nothing_more(
    ground,
    context,
    station,
    monkeypatch,
):
    class Cancelling(Here):
        def each(self, work, tasks, *, meanwhile):
            answers = super().each(work, tasks, meanwhile=meanwhile)
            yield next(answers)
            cancel_job(station, view.job.id, by=Actor("metrologist"))
            yield from answers

    monkeypatch.setattr(replaying, "workers_at", lambda _address: nullcontext(Cancelling()))
    ground.order_measuring("p1")
    view = order(station, pass_id="p1", calibrations=BOTH)
    done = replayed(on_cluster(context, NOWHERE), view)
    assert done.job.state == "cancelled"
    assert list(done.row.results) == ["pass.p1.left"]


def test_a_reference_in_a_file_of_the_station_is_measured_against_by_the_station(
    ground,
    context,
    station,
    tmp_path,
    monkeypatch,
):
    monkeypatch.setattr(replaying, "workers_at", None)
    worn = tmp_path / "worn.csv"
    worn.write_text("d_mm,h_mm\n")
    own = station.settings.model_copy(update={"reference": str(worn)})
    add_calibration(ground, "newer")
    ground.order_measuring("p1")
    view = order(
        replace(station, settings=own),
        recordings=["pass.p1.left"],
        calibrations={"left": "newer"},
    )
    done = replayed(on_cluster(replace(context, settings=own), NOWHERE), view)
    assert (done.job.state, done.measurements) == ("done", WHEELS)
    assert done.job.error == f"{worn} is a file of the station; measured here alone"
