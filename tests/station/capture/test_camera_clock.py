"""Camera times become UTC, whatever the camera's clock shows.

Delays are drawn here; that of a real network is shown where a simulated camera streams.
"""

import pytest

from station.capture.clock import CameraClock, ClockSample, ClockSource
from station.simulated import DeviceClock

START = 1_760_000_000_000_000_000
SECOND = 1_000_000_000
MILLISECOND = 1_000_000


def ask_every_second(clock, shown, seconds, rng, *, most_ns=200_000):
    """Ask a camera whose clock shows `shown(utc)` for its time; answers take up to `most_ns`."""
    for second in range(seconds):
        asked = START + second * SECOND
        there, back = rng.integers(1, most_ns, 2).tolist()
        half = (there + back) // 2
        clock.learn(ClockSample(shown(asked + there), asked + half, half))


def worst_error_ns(clock, shown, seconds):
    times = [START + round(step * 0.1 * SECOND) for step in range(10 * seconds)]
    return max(abs(clock.utc_ns(shown(utc), utc + 5 * MILLISECOND) - utc) for utc in times)


@pytest.mark.parametrize("drift_ppm", [50.0, -50.0, 0.0])
@pytest.mark.parametrize("offset_s", [0, -2000, 37, 0.004])
def test_wrong_clock_comes_out_within_half_a_millisecond(offset_s, drift_ppm, rng):
    wrong = DeviceClock(round(offset_s * SECOND), drift_ppm, since_ns=START)
    clock = CameraClock(SECOND)
    ask_every_second(clock, wrong.camera_ns, 60, rng)
    # Answers of up to 0.2 ms each way: the offset is known to 0.2 ms, its median far better.  A
    # clock that agrees to half a millisecond is believed.
    assert worst_error_ns(clock, wrong.camera_ns, 60) < 500_000 + 3000
    summary = clock.summary()
    # 59 s of samples with 0.1 ms of spread: a slope to 0.1 ms / 20 s = 5 ppm at worst.
    assert summary.drift_ppm == pytest.approx(drift_ppm, abs=5.0)
    assert summary.residual_us < 200.0


def test_slow_answers_do_not_move_the_clock(rng):
    wrong = DeviceClock(5 * SECOND, 50.0, since_ns=START)
    clock = CameraClock(SECOND)
    for second in range(40):
        asked = START + second * SECOND
        there = int(rng.integers(1, 100_000)) if second % 3 == 0 else 8 * MILLISECOND
        clock.learn(ClockSample(wrong.camera_ns(asked + there), asked + there // 2, there // 2 + 1))
    assert worst_error_ns(clock, wrong.camera_ns, 40) < 200_000


def test_drift_is_unknown_while_it_was_watched_too_briefly(rng):
    clock = CameraClock(SECOND)
    ask_every_second(clock, DeviceClock(SECOND).camera_ns, 3, rng)
    assert clock.summary().drift_ppm is None
    assert clock.summary().offset_ns == pytest.approx(-SECOND, abs=200_000)


def test_hours_of_samples_are_kept_in_bounded_memory(rng):
    wrong = DeviceClock(7 * SECOND, 20.0, since_ns=START)
    clock = CameraClock(SECOND)
    ask_every_second(clock, wrong.camera_ns, 1000, rng)
    assert clock.summary().samples <= 48
    assert clock.summary().drift_ppm == pytest.approx(20.0, abs=1.0)
    assert worst_error_ns(clock, wrong.camera_ns, 1000) < MILLISECOND


def test_clock_set_anew_is_noticed_and_followed(rng):
    clock = CameraClock(SECOND)
    ask_every_second(clock, DeviceClock(-4 * SECOND).camera_ns, 20, rng)
    ask_every_second(clock, DeviceClock(90 * SECOND).camera_ns, 2, rng)
    assert clock.jumps == 1
    assert worst_error_ns(clock, DeviceClock(90 * SECOND).camera_ns, 2) < MILLISECOND


def test_camera_that_keeps_utc_is_believed_to_the_nanosecond(rng):
    clock = CameraClock(SECOND)
    ask_every_second(clock, lambda utc: utc, 10, rng)
    assert clock.source is ClockSource.CAMERA_UTC
    assert clock.utc_ns(START + 7, START + 7 * MILLISECOND) == START + 7


def test_camera_that_cannot_be_asked_is_judged_by_its_quickest_frames(rng):
    exposure = 2 * MILLISECOND
    wrong = DeviceClock(-1000 * SECOND, 50.0, since_ns=START)
    clock = CameraClock(SECOND, exposure)
    errors = []
    for step in range(600):
        utc = START + step * SECOND // 20
        delay = 100_000 + int(rng.exponential(2 * MILLISECOND))
        found = clock.utc_ns(wrong.camera_ns(utc), utc + exposure + delay)
        errors.append(abs(found - utc))
    # Before the first second is over only the first frame tells, with its delay.
    assert max(errors[60:]) < MILLISECOND
    assert clock.source is ClockSource.CAMERA_MAPPED


def test_camera_without_a_clock_gives_the_time_of_reception():
    clock = CameraClock(0)
    assert clock.utc_ns(123, 456) == 456
    assert clock.source is ClockSource.HOST
    assert clock.summary().to_text()["clock_source"] == "host"
