"""A pass being recorded and followed, for tests: the frames come and time goes as they are told."""

from dataclasses import replace

import numpy as np
from rig_recordings import calibration_of, true_rig
from wheel_recordings import ONE_FILE, START_NS, true_calibration

from station.operations import utc_now
from station.pipeline import calibrate_rig_sources, calibrate_sources, measure_rig, measure_sources
from station.recording import RotatingWriter
from station.store import Calibration, JobKind, Pass, PassState, Recording, add_job, the
from station.store.measured import followings_of, profiles_of, wheels_of
from station.worker.context import Mathematics, WorkContext
from station.worker.followed import QUIET_S
from station.worker.following import PassFollower
from station.worker.measuring import begin_measuring, conclude_measuring, measure_step

REAL = Mathematics(calibrate_sources, measure_sources, calibrate_rig_sources, measure_rig)
PASS = "p1"


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


def ensure_as_afterwards(trackside):
    """The pass has what measuring its finished recordings gives, to the last bit."""
    found = [{**each["wheel"], "profile": each["profile"]} for each in trackside.seen.values()]
    expected = trackside.measured_afterwards()
    assert len(found) == len(expected), (trackside.frames, expected)
    other = [pair for pair in zip(found, expected, strict=True) if pair[0] != pair[1]]
    assert not other, other


def damage(path, *, from_the_end):
    """Write eight bytes over those of a file."""
    with path.open("r+b") as stream:
        stream.seek(-from_the_end, 2)
        stream.write(bytes(range(8)))
