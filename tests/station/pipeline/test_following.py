"""Shows that wheels followed while frames come are those of the finished recordings: for frames of
one or two sensors that come in any order and any pieces, are lost, or end in the middle of a wheel,
and for a follower that is killed and taken over at any time.  The pictures are one pixel and the
measuring only names its frames: that the numbers agree is shown with rendered wheels."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from calib import Cause, StripePoints
from measure import WheelFrame, each_shot, each_wheel
from measure.shot import MIN_STRIPE_POINTS
from station.documents import WheelDocument
from station.errors import InputUnusable
from station.pipeline import Looker, Resumption, UnreadBatch, WheelFollower
from station.recording import FilePlace, RecordedFrame

INNER, OUTER = "inner", "outer"
FROM_THE_BEGINNING = Resumption({})
NO_DOCUMENT = None


def stripe(points):
    return StripePoints(
        centre_px=np.arange(2.0 * points).reshape(-1, 2),
        normal=np.tile([0.0, 1.0], (points, 1)),
        sigma_px=np.ones(points),
        width_px=np.ones(points),
        peak=np.ones(points),
        saturated=np.zeros(points, dtype=bool),
        cause=(Cause.NONE,) * points,
    )


DARK, LIT = stripe(0), stripe(MIN_STRIPE_POINTS)


def locate(sensor, batch):
    return [
        WheelFrame(
            LIT if frame.picture[0, 0] else DARK, frame.number, batch.source, frame.time_ns, sensor
        )
        for frame in batch.frames()
    ]


def measure(shots):
    named = [f"{each.sensor}{each.frame}" for shot in shots for each in shot.frames]
    return WheelDocument(source=" ".join(named), sensor="wheel")


def recorded(sensor, number, time_ms, lit):
    picture = np.full((1, 1), 255 if lit else 0, np.uint8)
    return RecordedFrame(sensor, number, round(time_ms * 1e6), 0, picture, None)


@dataclass
class Train:
    """What the sensors of one looker take of it."""

    frames: dict

    @property
    def looker(self):
        return Looker(tuple(self.frames), locate, measure, NO_DOCUMENT)

    def follower(self, since=FROM_THE_BEGINNING):
        return WheelFollower(self.looker, {sensor: sensor for sensor in self.frames}, since)

    def wheels(self, since=FROM_THE_BEGINNING):
        """Return the wheels of the finished recordings, from a place on."""
        streams = {}
        for sensor, own in self.frames.items():
            rest = tuple(own[since.of(sensor).frames :])
            streams[sensor] = locate(sensor, Pictures(sensor, rest))
        shots = each_shot(streams)
        groups = each_wheel(shots, shown_before=since.shown_before)
        return [measure(group).source for group in groups]


@dataclass
class Pictures:
    source: str
    recorded: tuple

    def frames(self):
        for one in self.recorded:
            yield Numbered(one.frame_id, one.camera_time_ns, one.picture)


@dataclass
class Numbered:
    number: int
    time_ns: int
    picture: np.ndarray


@st.composite
def trains(draw, sensors=(INNER, OUTER)):
    used = sensors[: draw(st.integers(1, len(sensors)))]
    frames = {sensor: [] for sensor in used}
    time_ms = 1000.0
    for number in range(draw(st.integers(0, 25))):
        time_ms += draw(st.sampled_from([19, 19, 39, 500]))
        lit = draw(st.integers(0, 5)) > 0
        for place, own in enumerate(frames.values()):
            if draw(st.integers(0, 7)):
                skew_ms = draw(st.sampled_from([0.3, -0.4, 4.9]))
                own.append(recorded(used[place], number, time_ms + place * skew_ms, lit))
    return Train(frames)


@st.composite
def arrivals(draw, train):
    """Return pieces (sensor, how many frames): in which order and bits the frames come."""
    left = {sensor: len(own) for sensor, own in train.frames.items()}
    pieces = []
    while any(left.values()):
        sensor = draw(st.sampled_from([name for name, count in left.items() if count]))
        count = draw(st.integers(1, min(left[sensor], 4)))
        left[sensor] -= count
        pieces.append((sensor, count))
    return pieces[: draw(st.integers(0, len(pieces)))]


def take(follower, train, sensor, first, count):
    places = range(first, first + count)
    some = [(FilePlace(1, 8 + place, place), train.frames[sensor][place]) for place in places]
    return [wheel.source for wheel in follower.take(sensor, some)]


@given(st.data())
def test_wheels_said_to_be_over_are_those_of_the_finished_recordings(data):
    train = data.draw(trains())
    follower, over = train.follower(), []
    taken = dict.fromkeys(train.frames, 0)
    for sensor, count in data.draw(arrivals(train)):
        over += take(follower, train, sensor, taken[sensor], count)
        taken[sensor] += count
        if data.draw(st.booleans()):
            follower.open_wheels()
        assert over == train.wheels()[: len(over)]
        assert [*over, *train.wheels(follower.resumption)] == train.wheels()
    seen = Train({sensor: own[: taken[sensor]] for sensor, own in train.frames.items()})
    assert [*over, *(wheel.source for wheel in follower.open_wheels())] == seen.wheels()


@given(st.data())
def test_a_follower_takes_over_from_a_killed_one(data):
    train = data.draw(trains())
    follower, over = train.follower(), []
    taken = dict.fromkeys(train.frames, 0)
    for sensor, count in data.draw(arrivals(train)):
        over += take(follower, train, sensor, taken[sensor], count)
        taken[sensor] += count
        if data.draw(st.integers(0, 3)) == 0:
            since = follower.resumption
            follower = train.follower(since)
            taken = {name: since.of(name).frames for name in train.frames}
    assert [*over, *train.wheels(follower.resumption)] == train.wheels()


def a_train_of(wheels, frames_each, *, sensors=(INNER, OUTER)):
    return Train({
        sensor: [
            recorded(sensor, number, 500.0 * (number // frames_each) + 19.0 * number, lit=True)
            for number in range(wheels * frames_each)
        ]
        for sensor in sensors
    })


def test_a_wheel_is_over_with_the_first_frame_of_the_next_and_no_frame_is_kept_longer():
    train = a_train_of(3, 4, sensors=[INNER])
    follower = train.follower()
    over = [take(follower, train, INNER, place, 1) for place in range(12)]
    assert [len(wheels) for wheels in over] == [0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]
    assert follower.frames_open == 4
    assert follower.resumption.of(INNER).frames == 8


def test_a_wheel_of_two_sensors_waits_for_the_one_that_is_late():
    train = a_train_of(2, 4)
    follower = train.follower()
    assert take(follower, train, INNER, 0, 8) == []
    assert follower.frames_open == 8
    (open_wheel, _) = follower.open_wheels()
    assert open_wheel.source == "inner0 inner1 inner2 inner3"
    assert take(follower, train, OUTER, 0, 8) == train.wheels()[:1]


def test_an_open_wheel_is_measured_again_only_where_it_went_on():
    measured = []

    def note(shots):
        measured.append(len(shots))
        return measure(shots)

    train = a_train_of(2, 3, sensors=[INNER])
    follower = WheelFollower(
        Looker((INNER,), locate, note, NO_DOCUMENT), {INNER: INNER}, FROM_THE_BEGINNING
    )
    for place in range(4):
        take(follower, train, INNER, place, 1)
        follower.open_wheels()
        follower.open_wheels()
    # Of 1, 2, 3 frames, and the first frame of the next: what ended was known already.
    assert measured == [1, 2, 3, 1]


def test_a_frame_that_does_not_fit_ends_the_following():
    def refuse(sensor, batch):
        return UnreadBatch(batch.source, InputUnusable("of another camera"), sensor)

    train = a_train_of(1, 1, sensors=[INNER])
    follower = WheelFollower(
        Looker((INNER,), refuse, measure, NO_DOCUMENT), {INNER: INNER}, FROM_THE_BEGINNING
    )
    with pytest.raises(InputUnusable, match="another camera"):
        take(follower, train, INNER, 0, 1)
