"""Tasks are done once each, whoever dies meanwhile; one that kills its workers is named."""

import os
import signal
import time

import crew_tasks
import pytest

import station.replay.crew as replay_crew
from station.replay.cluster import local_workers
from station.replay.crew import Done, Failed, Here
from station.replay.work import OtherSoftware


@pytest.fixture(params=["here", "workers"])
def crew(request):
    return Here() if request.param == "here" else request.getfixturevalue("workers")


def results(answers):
    return sorted((one.task, one.result) for one in answers if isinstance(one, Done))


def test_every_task_is_answered_once(crew):
    answers = list(crew.each(crew_tasks.double, range(50)))
    assert len(answers) == 50
    assert results(answers) == [(n, 2 * n) for n in range(50)]


def test_a_task_that_fails_is_named_in_one_line_and_the_others_are_done(crew):
    answers = list(crew.each(crew_tasks.fail_of_three, range(6)))
    assert len(results(answers)) == 5
    (failed,) = (one for one in answers if isinstance(one, Failed))
    assert (failed.task, failed.why) == (3, "ZeroDivisionError: three is too much")


def test_a_worker_of_another_version_ends_the_work_at_once(crew):
    with pytest.raises(OtherSoftware, match="treadline 0"):
        list(crew.each(crew_tasks.refuse, range(100)))


def test_tasks_are_taken_a_few_ahead_of_the_answers(workers):
    taken = []

    def tasks():
        for number in range(1000):
            taken.append(number)
            yield number

    answers = workers.each(crew_tasks.double, tasks())
    next(answers)
    assert len(taken) <= 8  # twice the threads, and as many as were done in the meantime
    answers.close()


def test_what_a_killed_worker_had_is_done_by_another_and_nothing_is_answered_twice(
    workers, tmp_path
):
    tasks = [(str(tmp_path), number) for number in range(8)]
    answers = list(workers.each(crew_tasks.die_once, tasks))
    assert (tmp_path / "died").exists()
    assert [(task[1], result) for task, result in results(answers)] == [
        (number, 2 * number) for number in range(8)
    ]
    assert len(answers) == 8


def test_tasks_that_kill_every_worker_are_named_and_those_beside_them_are_done(
    workers, monkeypatch
):
    # One that dies while it is starting is started again when workers are counted.
    monkeypatch.setattr(replay_crew, "_COUNT_EACH_S", 0.5)
    # Each worker has one that kills it, and one behind that has done nothing.
    answers = list(workers.each(crew_tasks.die_of_three, [3, 3, 5, 6]))
    assert results(answers) == [(5, 10), (6, 12)]
    failed = [one for one in answers if isinstance(one, Failed)]
    assert [one.task for one in failed] == [3, 3]
    assert "2 workers died of it" in failed[0].why


def test_a_task_that_died_beside_another_is_done_again_by_itself(workers, monkeypatch):
    answer, told = replay_crew._answer, []

    def suspect_at_first(future, task):
        if task == 2 and not told:
            told.append(task)
            return replay_crew._Killer(task, "its worker died")
        return answer(future, task)

    monkeypatch.setattr(replay_crew, "_answer", suspect_at_first)
    assert results(workers.each(crew_tasks.double, range(4))) == [(n, 2 * n) for n in range(4)]
    assert told == [2]


@pytest.mark.slow
def test_workers_outlive_no_replay():
    with local_workers(1) as crew:
        (pid,) = crew.on_each(os.getpid)
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


def test_workers_listen_on_the_loopback_alone(workers):
    addresses = [*workers._client.nthreads(), workers._client.scheduler.address]
    assert all(address.startswith("tls://127.0.0.1:") for address in addresses)


def test_workers_leave_an_interrupt_of_the_terminal_to_the_one_that_replays(workers):
    deadline = time.monotonic() + 60.0
    while workers._threads_now() < 2:  # which starts those that died while they were starting
        assert time.monotonic() < deadline, "workers that died are not started again"
        time.sleep(0.1)
    pids = workers.on_each(os.getpid)
    for pid in pids:
        os.kill(pid, signal.SIGINT)
    assert results(workers.each(crew_tasks.double, range(4))) == [(n, 2 * n) for n in range(4)]
    assert sorted(workers.on_each(os.getpid)) == sorted(pids)
