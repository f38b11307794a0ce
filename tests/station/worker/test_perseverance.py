"""Shows that what passes by, a store that is away or a killed helper, costs a job time and no more.
The engine is left out; the steps are the jobs' own."""

from concurrent.futures.process import BrokenProcessPool

import pytest
from worker_double import WHEELS, SlowMathematics

from station.errors import InputUnusable, StoreUnusable
from station.store import Measurement, Pass, the
from station.worker.context import WorkContext
from station.worker.measuring import begin_measuring, conclude_measuring, measure_step
from station.worker.perseverance import persevering


class Failing:
    """Work that meets errors, one each time, before it is done."""

    def __init__(self, *errors):
        self.errors = list(errors)
        self.times = 0

    def __call__(self, what):
        self.times += 1
        if self.errors:
            raise self.errors.pop(0)
        return what


def test_a_store_that_is_away_is_waited_for_however_long_it_takes():
    naps, work = [], Failing(*[StoreUnusable("away")] * 20)
    assert persevering(work.__call__, naps.append)("done") == "done"
    assert len(naps) == 20


def test_a_helper_that_is_killed_again_and_again_ends_the_work():
    work = Failing(*[BrokenProcessPool()] * 5)
    with pytest.raises(BrokenProcessPool):
        persevering(work.__call__, lambda _: None)("done")
    assert work.times == 3


def test_an_error_of_the_work_itself_is_not_tried_again():
    work = Failing(InputUnusable("no target"))
    with pytest.raises(InputUnusable):
        persevering(work.__call__, lambda _: None)("done")
    assert work.times == 1


class UnluckyMathematics(SlowMathematics):
    """Measures as it should, the second time; before that something passes by."""

    def __init__(self, trace, error):
        super().__init__(trace, step_s=0.0)
        self.work = Failing(error)

    def measure(self, *args, **kwargs):
        self.work(None)
        return super().measure(*args, **kwargs)


@pytest.mark.parametrize("error", [StoreUnusable("away"), BrokenProcessPool("killed")])
def test_a_recording_is_measured_although_something_passed_by(ground, tmp_path, error):
    job_id = ground.order_measuring("p1", sensors=("left",))
    mathematics = UnluckyMathematics(tmp_path / "trace", error)
    context = WorkContext(ground.settings, ground.store, ground.layout, mathematics.parts)
    (step,) = begin_measuring(context, job_id)
    measure = persevering(measure_step, lambda _: None)
    conclude_measuring(context, job_id, [measure(context, job_id, step, place=0, of=1)])
    with ground.store.look() as session:
        assert the(session, Pass, "p1").state == "done"
        assert session.query(Measurement).count() == WHEELS
    assert mathematics.work.times == 2
