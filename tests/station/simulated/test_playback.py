"""A recording played again: its pictures, the times between them, its frame ids.

That the readings are the same as the live pass's is shown in tests/system.
"""

import json
import signal
import subprocess
import sys
import time
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from aravis_receiver import Receiver, wait_until
from simulated_pictures import numbered_pictures

from station.cli.main import build_app, run
from station.errors import InputUnusable
from station.recording import RecordingWriter, RotatingWriter, Rotation
from station.simulated import RecordingSource, SimulatedCamera
from station.simulated.acquisition import Acquisition, ExposureSettings
from station.simulated.gvsp import Region
from station.simulated.registers import TriggerSource

PICTURES = numbered_pictures(5, 64, 48)
STEPS_MS = (0, 20, 21, 500, 20)
IDS = (1, 2, 4, 5, 9)  # 3 and 6 to 8 are lost
START_NS = 1_760_000_000_123_456_789
OFFSETS_NS = tuple(np.cumsum(STEPS_MS) * 1_000_000)
BY_LINE1 = ExposureSettings(
    region=Region(64, 48),
    frames=None,
    trigger=TriggerSource.LINE1,
    period_s=0.01,
    exposure_us=1000.0,
    gained_exposure_us=1000.0,
)


def write(path, *, sensor="left", ids=IDS, offsets_ns=OFFSETS_NS, pictures=PICTURES):
    with RecordingWriter(path) as writer:
        for frame_id, offset_ns, picture in zip(ids, offsets_ns, pictures, strict=True):
            time_ns = START_NS + int(offset_ns)
            pixels = picture.data.cast("B")
            writer.write_frame(sensor, frame_id, time_ns, time_ns, pixels, 64, 48)
    return path


@pytest.fixture
def recording(tmp_path):
    return write(tmp_path / "left.mcap")


def play(source, count):
    shots = []
    while len(shots) < count and (shot := source.upcoming()) is not None:
        shots.append(shot)
        source.take()
    return shots


def test_times_between_pictures_and_frame_ids_are_the_recordings(recording):
    shots = play(RecordingSource(recording, once=True), 99)
    assert [shot.after_ns for shot in shots] == list(OFFSETS_NS)
    assert [shot.block_id for shot in shots] == list(IDS)
    for shot, picture in zip(shots, PICTURES, strict=True):
        np.testing.assert_array_equal(shot.picture, picture)


def test_a_round_follows_the_last_after_the_longest_pause_with_ids_going_on(recording):
    shots = play(RecordingSource(recording), 10)
    assert [shot.block_id for shot in shots[5:]] == [10, 11, 13, 14, 18]
    steps = [after.after_ns - before.after_ns for before, after in pairwise(shots)]
    assert steps[4] == 500_000_000
    assert steps[5:] == steps[:4]


def test_an_even_rate_replaces_the_times(recording):
    shots = play(RecordingSource(recording, rate_hz=30.0), 7)
    assert [shot.after_ns for shot in shots] == [round(k * 1e9 / 30.0) for k in range(7)]


@pytest.mark.parametrize(
    ("recorded", "sent"),
    [
        ((65_534, 65_535, 2), [65_534, 65_535, 2]),
        ((70_000, 70_002, 70_003), [4465, 4467, 4468]),
        ((7, 8, 1), [7, 8, 9]),
    ],
    ids=["wraps", "64-bit", "camera opened again"],
)
def test_ids_are_such_as_the_wire_carries_and_never_go_back(tmp_path, recorded, sent):
    path = write(
        tmp_path / "r.mcap", ids=recorded, offsets_ns=OFFSETS_NS[:3], pictures=PICTURES[:3]
    )
    assert [shot.block_id for shot in play(RecordingSource(path, once=True), 99)] == sent


def test_a_clock_set_back_does_not_turn_the_order_round(tmp_path):
    path = write(tmp_path / "r.mcap", offsets_ns=(0, 20, 5, 30, 50))
    after = [shot.after_ns for shot in play(RecordingSource(path, once=True), 99)]
    assert after == [0, 20, 20, 45, 65]


def test_all_files_of_a_recording_are_played(tmp_path):
    path = tmp_path / "left.mcap"
    metadata = {"session": {"id": "s"}}
    writer = RotatingWriter(path, "left", rotation=Rotation(size_bytes=1), metadata=metadata)
    for number, picture in enumerate(PICTURES, start=1):
        writer.write_frame(number, number, number, picture.data.cast("B"), 64, 48)
        time.sleep(0.05)  # the next file is begun once the last is closed
    assert len(writer.finish().paths) > 1
    shots = play(RecordingSource(path, once=True), 99)
    assert [shot.block_id for shot in shots] == [1, 2, 3, 4, 5]
    assert [shot.after_ns for shot in shots] == [0, 1, 2, 3, 4]


def test_one_of_several_sensors_is_played_and_must_be_named(tmp_path):
    path = tmp_path / "both.mcap"
    with RecordingWriter(path) as writer:
        for number, (sensor, picture) in enumerate(
            zip(("left", "right", "left"), PICTURES, strict=False), start=1
        ):
            writer.write_frame(sensor, number, number, number, picture.data.cast("B"), 64, 48)
    shots = play(RecordingSource(path, "left", once=True), 99)
    assert [shot.block_id for shot in shots] == [1, 3]
    with pytest.raises(InputUnusable, match=r"several sensors in it \(left, right\)"):
        RecordingSource(path)
    with pytest.raises(InputUnusable, match=r"'middle' in it; it has those of: left, right"):
        RecordingSource(path, "middle")


class Clock:
    now_s = 50.0

    def acquisition(self, settings, playback):
        return Acquisition(
            lambda: settings,
            playback=playback,
            monotonic_s=lambda: self.now_s,
            utc_ns=lambda: START_NS,
        )


@pytest.mark.parametrize("trigger", [None, TriggerSource.LINE1], ids=["free run", "Line1"])
def test_exposures_carry_the_times_of_the_recording_however_late_they_are(recording, trigger):
    clock = Clock()
    playing = clock.acquisition(replace(BY_LINE1, trigger=trigger), RecordingSource(recording))
    playing.start()
    clock.now_s += 10.0
    exposures = [playing.next_exposure() for _ in IDS]
    assert [each.timestamp_ns - START_NS for each in exposures] == list(OFFSETS_NS)
    assert [each.block_id for each in exposures] == list(IDS)


def test_every_acquisition_plays_from_the_first_picture(recording):
    clock = Clock()
    playing = clock.acquisition(BY_LINE1, RecordingSource(recording, once=True))
    for _ in range(2):
        playing.start()
        clock.now_s += 10.0
        assert [playing.next_exposure().block_id for _ in IDS] == list(IDS)
        assert not playing.played_out  # whoever receives may still ask for packets again
        playing.stop()
        assert playing.played_out


def test_the_trigger_line_belongs_to_the_recording(recording):
    playing = Clock().acquisition(BY_LINE1, RecordingSource(recording))
    playing.start()
    assert not playing.trigger(TriggerSource.LINE1)
    assert playing.missed_triggers == 1


def test_software_triggers_take_the_pictures_one_by_one(recording):
    settings = replace(BY_LINE1, trigger=TriggerSource.SOFTWARE)
    playing = Clock().acquisition(settings, RecordingSource(recording, once=True))
    playing.start()
    for frame_id, picture in zip(IDS, PICTURES, strict=True):
        assert playing.trigger(TriggerSource.SOFTWARE)
        exposure = playing.next_exposure()
        assert exposure.block_id == frame_id
        np.testing.assert_array_equal(exposure.picture, picture)
    assert not playing.trigger(TriggerSource.SOFTWARE)


def test_a_receiver_gets_the_recording_pixel_by_pixel_at_its_times(recording):
    with SimulatedCamera("127.30.1.1", RecordingSource(recording, once=True)) as camera:
        receiver = Receiver("127.30.1.1")
        with receiver:
            frames = receiver.take(len(IDS))
        receiver.close()
        assert wait_until(lambda: camera.played_out)
    assert [frame.frame_id for frame in frames] == list(IDS)
    assert [frame.data for frame in frames] == [picture.tobytes() for picture in PICTURES]
    first_ns = frames[0].timestamp_ns
    assert [frame.timestamp_ns - first_ns for frame in frames] == list(OFFSETS_NS)


def test_a_simulation_of_a_recording_ends_once_it_was_received(recording):
    command = "from station.cli import main; main()"
    arguments = ["camera", "simulate", "--address", "127.30.1.2", "--from", str(recording)]
    process = subprocess.Popen(
        [sys.executable, "-c", command, *arguments, "--once", "--rate", "100", "--json"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    with process:
        assert "100 pictures a second" in process.stderr.readline()
        receiver = Receiver("127.30.1.2")
        with receiver:
            assert len(receiver.take(len(IDS))) == len(IDS)
        receiver.close()
        try:
            out, _ = process.communicate(timeout=60)
        finally:
            process.send_signal(signal.SIGKILL)
    assert process.returncode == 0
    assert json.loads(out)["sent"] == len(IDS)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--once"], "give --from FILE.mcap"),
        (["--from", "RECORDING", "--line1-hz", "5"], "its own trigger"),
        (["--from", "RECORDING", "--sensor", "right"], "'right'"),
    ],
)
def test_what_cannot_be_played_is_one_line_and_exit_2(recording, capsys, arguments, message):
    given = [str(recording) if word == "RECORDING" else word for word in arguments]
    command = ["camera", "simulate", "--address", "127.30.1.3", *given]
    assert run(build_app("camera"), command) == 2
    err = capsys.readouterr().err
    assert message in err
    assert err.count("\n") == 1
