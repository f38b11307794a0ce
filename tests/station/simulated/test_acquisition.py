"""When exposures come, how they are numbered and timed; the clock is the test's own."""

import threading
from dataclasses import replace

import pytest

from station.simulated.acquisition import MAX_WAITING_TRIGGERS, Acquisition, ExposureSettings
from station.simulated.gvsp import Region
from station.simulated.registers import TriggerSource

FREE_RUN = ExposureSettings(
    region=Region(64, 48),
    frames=None,
    trigger=None,
    period_s=0.02,
    exposure_us=1000.0,
    gained_exposure_us=1000.0,
)
BY_LINE1 = replace(FREE_RUN, trigger=TriggerSource.LINE1)


class Clock:
    def __init__(self):
        self.now_s = 50.0

    def monotonic_s(self):
        return self.now_s

    def utc_ns(self):
        return 1_700_000_000_000_000_000 + round((self.now_s - 50.0) * 1e9)


@pytest.fixture
def clock():
    return Clock()


def acquisition(clock, settings, **options):
    return Acquisition(
        lambda: settings, monotonic_s=clock.monotonic_s, utc_ns=clock.utc_ns, **options
    )


def test_free_run_is_timed_by_its_schedule_not_by_its_waking(clock):
    running = acquisition(clock, FREE_RUN)
    running.start()
    stamps = []
    for _ in range(5):
        stamps.append(running.next_exposure().timestamp_ns)
        clock.now_s += 0.02 + 1e-4 * len(stamps)  # woken ever later
    steps = {later - earlier for earlier, later in zip(stamps, stamps[1:], strict=False)}
    # Double precision at 50 s resolves 7e-15 s; rounding to ns leaves 1.
    assert all(abs(step - 20_000_000) <= 1 for step in steps)


def test_a_slow_source_sets_the_pace_and_nothing_is_caught_up(clock):
    running = acquisition(clock, FREE_RUN)
    running.start()
    running.next_exposure()
    clock.now_s += 1.0
    first = running.next_exposure()
    late = running.next_exposure()
    assert late.timestamp_ns - first.timestamp_ns == pytest.approx(0.98e9, abs=2)


def test_triggers_carry_their_own_times_in_order(clock):
    running = acquisition(clock, BY_LINE1)
    running.start()
    times = [5, 7, 2**63]
    assert all(running.trigger(TriggerSource.LINE1, at) for at in times)
    assert [running.next_exposure().timestamp_ns for _ in times] == times


def test_an_exposure_follows_its_trigger_by_the_delay(clock):
    running = acquisition(clock, replace(BY_LINE1, delay_s=0.25))
    running.start()
    assert running.trigger(TriggerSource.LINE1, 1000)
    exposure = running.next_exposure()
    assert exposure.timestamp_ns == 250_001_000
    assert exposure.ready_s == pytest.approx(50.0 + 0.25 + 0.001)


def test_edges_within_the_debounce_time_of_the_last_are_none(clock):
    running = acquisition(clock, replace(BY_LINE1, debounce_s=0.01))
    running.start()
    taken = []
    for _ in range(6):
        taken.append(running.trigger(TriggerSource.LINE1))
        clock.now_s += 0.004 if len(taken) < 3 else 0.02
    assert taken == [True, False, False, True, True, True]


def test_a_trigger_without_a_time_carries_the_present_one(clock):
    running = acquisition(clock, BY_LINE1)
    running.start()
    clock.now_s += 0.25
    running.trigger(TriggerSource.LINE1)
    assert running.next_exposure().timestamp_ns == clock.utc_ns()


@pytest.mark.parametrize(
    ("settings", "started"), [(FREE_RUN, True), (BY_LINE1, False)], ids=["free run", "stopped"]
)
def test_a_trigger_nobody_waits_for_is_missed_and_counted(clock, settings, started):
    idle = acquisition(clock, settings)
    if started:
        idle.start()
    assert not idle.trigger(TriggerSource.LINE1)
    assert idle.missed_triggers == 1


def test_a_trigger_of_another_source_is_missed(clock):
    running = acquisition(clock, BY_LINE1)
    running.start()
    assert not running.trigger(TriggerSource.SOFTWARE)


def test_triggers_beyond_what_the_camera_remembers_are_missed(clock):
    running = acquisition(clock, BY_LINE1)
    running.start()
    taken = [running.trigger(TriggerSource.LINE1) for _ in range(MAX_WAITING_TRIGGERS + 3)]
    assert taken.count(False) == running.missed_triggers == 3


@pytest.mark.parametrize("frames", [1, 3])
def test_an_acquisition_of_so_many_frames_ends_by_itself(clock, frames):
    running = acquisition(clock, replace(BY_LINE1, frames=frames))
    running.start()
    for _ in range(frames):
        assert running.running
        running.trigger(TriggerSource.LINE1)
        running.next_exposure()
    assert not running.running
    assert not running.trigger(TriggerSource.LINE1)


def test_block_ids_begin_anew_with_each_acquisition_and_indices_go_on(clock):
    running = acquisition(clock, BY_LINE1)
    seen = []
    for _ in range(2):
        running.start()
        for _ in range(2):
            running.trigger(TriggerSource.LINE1)
            exposure = running.next_exposure()
            seen.append((exposure.index, exposure.block_id, exposure.acquisition))
        running.stop()
    assert seen == [(0, 1, 1), (1, 2, 1), (2, 1, 2), (3, 2, 2)]


def test_block_ids_wrap_to_1(clock):
    running = acquisition(clock, BY_LINE1, first_block_id=65534)
    running.start()
    ids = []
    for _ in range(4):
        running.trigger(TriggerSource.LINE1)
        ids.append(running.next_exposure().block_id)
    assert ids == [65534, 65535, 1, 2]


def test_triggers_left_over_do_not_expose_in_the_next_acquisition(clock):
    running = acquisition(clock, BY_LINE1)
    running.start()
    running.trigger(TriggerSource.LINE1, 1)
    running.stop()
    running.start()
    running.trigger(TriggerSource.LINE1, 2)
    assert running.next_exposure().timestamp_ns == 2


def test_closing_ends_a_waiting_sensor(clock):
    running = acquisition(clock, BY_LINE1)
    running.start()
    seen = []
    sensor = threading.Thread(target=lambda: seen.append(running.next_exposure()))
    sensor.start()
    running.close()
    sensor.join(5.0)
    assert seen == [None]
