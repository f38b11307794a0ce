"""Shows that a pass is measured while it is recorded, and that what stands in the end is, bit for
bit, what measuring the finished recordings gives: with files that go on in next ones, rigs, lost
frames, wheels thought over too early, killed followers and files that a crash cut.  The pictures
are rendered wheels; time does not run but is told."""

import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from rig_recordings import INNER, OUTER, TRIGGERS_APART_NS, calibration_of, true_rig
from wheel_recordings import (
    FILE_FOR_EACH_FRAME,
    NEXT_WHEEL_MS,
    ONE_FILE,
    SAME_WHEEL_MS,
    START_NS,
    true_calibration,
    views_of,
)

from station.errors import StoreUnusable
from station.operations import utc_now
from station.pipeline import (
    calibrate_rig_sources,
    calibrate_sources,
    gauge,
    measure_rig,
    measure_sources,
    rig_gauge,
)
from station.recording import RotatingWriter, active_path, recover
from station.scenes import WheelTruth
from station.store import (
    Calibration,
    CalibrationState,
    JobKind,
    Pass,
    PassState,
    Recording,
    RigCalibration,
    add_job,
    the,
)
from station.store.disposal import measured_recordings
from station.store.lists import measurements_page
from station.store.measured import followings_of, profiles_of, wheels_of
from station.worker.context import Mathematics, WorkContext
from station.worker.followed import QUIET_S
from station.worker.following import PassFollower
from station.worker.measuring import begin_measuring, conclude_measuring, measure_step

REAL = Mathematics(calibrate_sources, measure_sources, calibrate_rig_sources, measure_rig)
PASS = "p1"
OFFSETS_MM = (-20.0, 10.0)


@pytest.fixture(scope="module")
def wheels():
    """Return the pictures of two wheels."""
    rng = np.random.default_rng(7)
    truths = [WheelTruth("S1002", tread_wear_mm=wear_mm) for wear_mm in (1.0, 2.5)]
    return [views_of(each, OFFSETS_MM, rng, seed=3 + at) for at, each in enumerate(truths)]


@pytest.fixture
def located(monkeypatch):
    """Count how often a stripe is looked for."""
    count = []
    for module in (gauge, rig_gauge):
        locate = module.locate_wheel_stripe
        monkeypatch.setattr(
            module, "locate_wheel_stripe", lambda p, found=locate: count.append(1) or found(p)
        )
    return count


class Trackside:
    """A pass being recorded, and the worker's thread that follows it, a turn at a time."""

    def __init__(self, ground, sensors=("left",), *, rig=None, rotation=ONE_FILE):
        self.ground, self.sensors, self.rig = ground, sensors, rig
        self.time_s = 0.0
        self.context = WorkContext(ground.settings, ground.store, ground.layout, REAL)
        self.follower = self.new_follower()
        self.writers = {
            each: RotatingWriter(
                ground.layout.root / f"{each}.mcap",
                each,
                rotation=rotation,
                metadata={"session": {"id": PASS}},
            )
            for each in sensors
        }
        self.frame = dict.fromkeys(sensors, 0)
        with ground.store.change() as session:
            for each in sensors:
                if rig is None:
                    row = the(session, Calibration, f"of-{each}")
                    row.document = true_calibration(each).model_dump_json()
            session.add(Pass(id=PASS, state=PassState.RECORDING, opened_at=utc_now()))
            session.add_all(
                Recording(
                    id=f"pass.{PASS}.{each}",
                    sensor=each,
                    pass_id=PASS,
                    path=f"{each}.mcap",
                    opened_at=utc_now(),
                    calibration_id=f"of-{each}",
                    rig_calibration_id=rig,
                    closed_at=utc_now(),
                    recovered=False,
                )
                for each in sensors
            )

    def new_follower(self):
        """Return a follower that knows nothing of another one, as after a kill."""
        return PassFollower(self.context, lambda: self.time_s)

    def write(self, sensor, picture, time_ms):
        self.frame[sensor] += 1
        time_ns = START_NS + round(time_ms * 1e6)
        height, width = picture.shape
        pixels = np.ascontiguousarray(picture).data.cast("B")
        writer = self.writers[sensor]
        writer.write_frame(self.frame[sensor], time_ns, time_ns, pixels, width, height)
        writer._wait_for_closing()

    def turn(self, *, quiet=False):
        """Let the follower take all there is; then, if it is quiet for long, look at the rest."""
        self.time_s += 1.0  # time for a look whether a pass is recorded
        while self.follower.turn():
            pass
        if quiet:
            self.time_s += QUIET_S
            self.follower.turn()

    def finish(self):
        """Close the recordings, have the pass measured, and return its wheels."""
        for each in self.writers.values():
            each.finish({})
        return self.measure()

    def measure(self):
        with self.ground.store.change() as session:
            the(session, Pass, PASS).state = PassState.MEASURING
            job = add_job(session, "job", JobKind.MEASURE, PASS, at=utc_now())
            the(session, Pass, PASS).job_id = job.id
            for each in self.sensors:
                the(session, Recording, f"pass.{PASS}.{each}").recorded = self.frame[each]
        context = replace(self.context, let_go=self.follower.let_go)
        results = []
        for place, step in enumerate(steps := begin_measuring(context, job.id)):
            results.append(measure_step(context, job.id, step, place=place, of=len(steps)))
        conclude_measuring(context, job.id, results)
        self.results = results
        with self.ground.store.look() as session:
            assert the(session, Pass, PASS).state is PassState.DONE, the(session, Pass, PASS).reason
            ids = [f"pass.{PASS}.{each}" for each in self.sensors]
            left = {row.recording_id for row in followings_of(session, ids)}
        assert left == {each["recording"] for each in results if "refused" in each}
        return self.seen

    @property
    def seen(self):
        """The wheels of the pass, as the API gives them: id, frames, and all that is said."""
        with self.ground.store.look() as session:
            rows = wheels_of(session, the(session, Pass, PASS))
            profiles = profiles_of(session, rows)
            return {
                row.id: {
                    "recording": row.recording_id,
                    "frame": row.frame,
                    "sensor": row.sensor,
                    "reference": row.reference,
                    "regime": row.regime,
                    "software": row.software,
                    "wheel": row.wheel,
                    "profile": profiles.get(row.id),
                }
                for row in rows
            }

    @property
    def frames(self):
        return [each["wheel"]["frames"] for each in self.seen.values()]

    def measured_afterwards(self):
        """Return what measuring the finished recordings alone gives."""
        root = self.ground.layout.root
        files = {each: root / f"{each}.mcap" for each in self.sensors}
        settings = self.ground.settings
        if self.rig is None:
            found = measure_sources(list(files.values()), true_calibration(self.sensors[0]))
        else:
            calibrations = [calibration_of(each) for each in self.sensors]
            found = measure_rig(files, true_rig(), calibrations=calibrations, all_sound=False)
        assert found.reference == settings.reference
        return [each.model_dump(mode="json") for each in found.wheels]


def whole(wheel):
    return {**wheel["wheel"], "profile": wheel["profile"]}


def assert_as_afterwards(trackside):
    assert [whole(each) for each in trackside.seen.values()] == trackside.measured_afterwards()


def roll_by(trackside, wheels, *, quiet=()):
    """Write the wheels frame by frame, with a turn after each; quiet after frames (wheel, view)."""
    for number, views in enumerate(wheels):
        for place, picture in enumerate(views):
            time_ms = number * NEXT_WHEEL_MS + place * SAME_WHEEL_MS
            trackside.write("left", picture, time_ms)
            trackside.turn(quiet=(number, place) in quiet)


def test_a_wheel_is_read_while_its_pass_is_recorded_and_the_reading_stays(ground, wheels, located):
    here = Trackside(ground)
    roll_by(here, wheels, quiet=[(0, 1)])
    assert here.frames == [[1, 2]]
    early = dict(here.seen)
    here.turn(quiet=True)
    assert here.frames == [[1, 2], [3, 4]]
    at_the_end = dict(here.seen)
    here.finish()
    assert here.seen == at_the_end
    assert list(here.seen.items())[0] == next(iter(early.items()))
    assert len(located) == 4  # no frame was looked at twice
    assert_as_afterwards(here)


def test_a_wheel_thought_over_too_early_is_read_anew_when_it_goes_on(ground, wheels):
    here = Trackside(ground)
    roll_by(here, wheels, quiet=[(0, 0)])
    assert here.frames == [[1, 2]]
    with ground.store.look() as session:
        assert len(measurements_page(session, limit=9).rows) == 1
    here.finish()
    assert here.frames == [[1, 2], [3, 4]]
    assert_as_afterwards(here)


def test_a_recording_that_goes_on_in_next_files_is_followed_through_them(ground, wheels, located):
    here = Trackside(ground, rotation=FILE_FOR_EACH_FRAME)
    roll_by(here, wheels)
    assert here.frames == [[1, 2]]
    here.finish()
    assert len(located) == 4
    assert_as_afterwards(here)


def test_a_follower_goes_on_where_a_killed_one_was(ground, wheels, located):
    here = Trackside(ground)
    for number, views in enumerate(wheels):
        for place, picture in enumerate(views):
            here.write("left", picture, number * NEXT_WHEEL_MS + place * SAME_WHEEL_MS)
        here.turn(quiet=True)
        here.follower = here.new_follower()
    before = dict(here.seen)
    here.turn(quiet=True)
    assert here.seen == before
    here.finish()
    assert here.seen == before
    # Each follower looks at the frames of the wheel that was not certain when it began.
    assert len(located) == 2 + 4 + 2
    assert_as_afterwards(here)


def test_a_pass_that_nobody_followed_is_measured_whole(ground, wheels, located):
    here = Trackside(ground)
    for number, views in enumerate(wheels):
        for place, picture in enumerate(views):
            here.write("left", picture, number * NEXT_WHEEL_MS + place * SAME_WHEEL_MS)
    here.finish()
    assert len(located) == 4
    assert_as_afterwards(here)


def test_readings_of_a_recording_that_a_crash_cut_are_made_anew(ground, wheels):
    """The disk lost frames that had been measured, and wheels with them."""
    here = Trackside(ground)
    roll_by(here, wheels)
    here.turn(quiet=True)
    (writer,) = here.writers.values()
    unfinished = active_path(writer._path)
    size = unfinished.stat().st_size
    writer._writer._file.abandon()
    with unfinished.open("r+b") as stream:
        stream.truncate(size * 3 // 8)  # in the middle of the second frame
    recover(unfinished)
    here.frame["left"] = 1
    here.measure()
    assert here.frames == [[1]]
    assert_as_afterwards(here)


def test_readings_by_another_reference_do_not_stand_beside_those_of_the_settings(ground, wheels):
    here = Trackside(ground)
    roll_by(here, wheels)
    other = ground.settings.model_copy(update={"reference": "LMA"})
    here.context = replace(here.context, settings=other)
    here.finish()
    assert {each["reference"] for each in here.seen.values()} == {"LMA"}
    assert here.frames == [[1, 2], [3, 4]]


def damage(path, *, from_the_end):
    with path.open("r+b") as stream:
        stream.seek(-from_the_end, 2)
        stream.write(bytes(range(8)))


def test_a_frame_that_is_damaged_leaves_the_pass_to_the_job(ground, wheels):
    here = Trackside(ground)
    roll_by(here, wheels[:1])
    damage(active_path(ground.layout.root / "left.mcap"), from_the_end=1000)
    follower = here.follower = here.new_follower()
    here.turn(quiet=True)
    assert here.seen == {}
    assert follower._followed == {PASS: []}


def test_a_pass_that_failed_is_let_go_of_and_nothing_is_kept_of_it_any_more(ground, wheels):
    here = Trackside(ground)
    here.write("left", wheels[0][0], 0.0)
    here.turn()
    with ground.store.change() as session:
        the(session, Pass, PASS).state = PassState.FAILED
    here.turn(quiet=True)
    assert (here.seen, here.follower._followed) == ({}, {})


def test_the_thread_follows_by_itself_past_a_store_that_is_away_for_a_moment(
    ground, wheels, monkeypatch
):
    here = Trackside(ground)
    follower = PassFollower(here.context)
    look, away = type(ground.store).look, [True]

    def look_or_not(store):
        if away and threading.current_thread() is follower._thread:
            away.pop()
            raise StoreUnusable("the store is away")
        return look(store)

    monkeypatch.setattr(type(ground.store), "look", look_or_not)
    follower.start()
    for place, picture in enumerate(wheels[0]):
        here.write("left", picture, place * SAME_WHEEL_MS)
    deadline = time.monotonic() + 30.0
    while here.frames != [[1, 2]]:
        assert time.monotonic() < deadline, here.frames
        time.sleep(0.02)
    follower.stop()
    assert (away, follower._followed) == ([], {})


@pytest.fixture
def rig_ground(ground):
    with ground.store.change() as session:
        for sensor in (INNER, OUTER):
            row = the(session, Calibration, f"of-{sensor}")
            row.document = calibration_of(sensor).model_dump_json()
        session.add(
            RigCalibration(
                id="true",
                state=CalibrationState.READY,
                rig="wheel",
                created_at=utc_now(),
                document=true_rig().model_dump_json(),
            )
        )
    return ground


def roll_by_rig(trackside, shots, *, lost=(), late=None):
    """Write wheels of the same shots; `late` comes only after all of the other sensor's."""
    kept = []
    for number in range(3):
        for place, pictures in enumerate(shots):
            for skew, sensor in enumerate(trackside.sensors):
                time_ms = number * NEXT_WHEEL_MS + place * SAME_WHEEL_MS
                time_ms += skew * TRIGGERS_APART_NS / 1e6
                if (number, place, sensor) in lost:
                    continue
                kept.append((sensor, pictures[sensor], time_ms))
    for sensor, picture, time_ms in sorted(kept, key=lambda each: each[0] == late):
        trackside.write(sensor, picture, time_ms)
        trackside.turn(quiet=True)


@pytest.mark.parametrize("late", [None, OUTER])
def test_a_rig_is_followed_whichever_sensor_is_late(rig_ground, rig_shots, located, late):
    here = Trackside(rig_ground, (INNER, OUTER), rig="true")
    roll_by_rig(here, rig_shots[:1], lost=[(1, 0, OUTER)], late=late)
    assert here.frames == [[1], [2], [3]]
    here.finish()
    assert here.frames == [[1], [2], [3]]
    assert len(located) == 5
    assert_as_afterwards(here)


def test_a_sensor_that_recorded_nothing_is_said_in_each_reading_in_the_end(rig_ground, rig_shots):
    here = Trackside(rig_ground, (INNER, OUTER), rig="true")
    for number in range(2):
        here.write(INNER, rig_shots[0][INNER], number * NEXT_WHEEL_MS)
        here.turn(quiet=True)
    assert here.frames == [[1], [2]]
    here.finish()
    assert here.frames == [[1], [2]]
    said = [each["wheel"]["quality"]["by_sensor"][OUTER] for each in here.seen.values()]
    assert [each["reason"] for each in said] == ["no frame was recorded"] * 2


def test_no_reading_rests_on_a_recording_of_which_nothing_was_saved(rig_ground, rig_shots):
    here = Trackside(rig_ground, (INNER, OUTER), rig="true")
    roll_by_rig(here, rig_shots[:1])
    here.frame[OUTER] = 0  # as what a crash left of it says
    here.finish()
    said = [each["wheel"]["quality"]["by_sensor"][OUTER] for each in here.seen.values()]
    assert [each["reason"] for each in said] == ["no frame was recorded"] * 3


def test_a_sensor_damaged_in_the_end_has_no_part_in_the_readings_before(rig_ground, rig_shots):
    here = Trackside(rig_ground, (INNER, OUTER), rig="true")
    roll_by_rig(here, rig_shots[:1])
    assert len(here.frames) == 3
    here.follower = here.new_follower()  # the worker was killed, and the disk failed
    for each in here.writers.values():
        each.finish({})
    damage(rig_ground.layout.root / f"{OUTER}.mcap", from_the_end=len(rig_shots[0][OUTER]) * 1000)
    here.measure()
    said = [each["wheel"]["quality"]["by_sensor"][OUTER] for each in here.seen.values()]
    assert ["damaged" in each["reason"] for each in said] == [True] * 3
    assert_as_afterwards(here)


def test_a_recording_that_cannot_be_measured_to_its_end_keeps_its_readings_and_is_kept(
    ground, wheels
):
    """Of two sensors one is damaged behind its first wheel; the pass is done by the other."""
    here = Trackside(ground, ("left", "right"))
    for number, views in enumerate(wheels):
        for place, picture in enumerate(views):
            for sensor in here.sensors:
                here.write(sensor, picture, number * NEXT_WHEEL_MS + place * SAME_WHEEL_MS)
        here.turn(quiet=True)
        here.follower = here.new_follower()
    before = dict(here.seen)
    for each in here.writers.values():
        each.finish({})
    damage(ground.layout.root / "right.mcap", from_the_end=len(wheels[1][1]) * 1000)
    here.follower.stop()
    here.measure()
    assert "damaged" in here.results[1]["refused"]
    assert here.seen == before
    with ground.store.look() as session:
        assert [each.sensor for each in measured_recordings(session)] == ["left"]
