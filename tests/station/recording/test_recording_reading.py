"""What was written is read back; what cannot be read is named in one line."""

import numpy as np
import pytest
from recording_samples import (
    CALIBRATION,
    PERIOD_NS,
    START_NS,
    make_recording,
    picture,
    write_picture,
)

from station.errors import InputUnusable, NotFound, RecordingUnreadable
from station.recording import (
    Event,
    EventKind,
    RecordingWriter,
    attachment,
    events,
    frames,
    info,
    verify,
)


@pytest.fixture
def recording(tmp_path, rng):
    make_recording(tmp_path / "a.mcap", rng)
    return tmp_path / "a.mcap"


def test_frames_come_back_with_times_ids_and_exposure(tmp_path, rng):
    pictures = make_recording(tmp_path / "a.mcap", rng)
    found = list(frames(tmp_path / "a.mcap"))
    assert [frame.frame_id for frame in found] == [1, 2, 3, 4, 5]
    for frame, pixels in zip(found, pictures, strict=True):
        np.testing.assert_array_equal(frame.picture, pixels)
        assert frame.sensor == "left"
        assert frame.camera_time_ns == START_NS + frame.frame_id * PERIOD_NS
        assert frame.host_time_ns == frame.camera_time_ns + 5_000_000
        assert frame.exposure_us == 250.0


def test_picture_of_a_frame_cannot_be_changed(recording):
    frame = next(frames(recording))
    with pytest.raises(ValueError, match="read-only"):
        frame.picture[0, 0] = 1


def test_one_sensor_of_two_can_be_read_alone(tmp_path, rng):
    with RecordingWriter(tmp_path / "two.mcap") as writer:
        for number in range(1, 4):
            write_picture(writer, number, picture(rng), sensor="left")
            write_picture(writer, number, picture(rng, 20, 10), sensor="right")
    assert {frame.picture.shape for frame in frames(tmp_path / "two.mcap", "right")} == {(20, 10)}
    assert len(list(frames(tmp_path / "two.mcap"))) == 6
    assert [one.frames for one in info(tmp_path / "two.mcap").sensors] == [3, 3]


def test_info_says_what_is_in_it(recording):
    found = info(recording)
    assert (found.sensors[0].frames, found.sensors[0].events) == (5, 1)
    assert found.metadata["camera"]["exposure_us"] == "250.0"
    assert found.attachments == {"calibration.json": len(CALIBRATION)}
    assert found.duration_s == pytest.approx((5 * PERIOD_NS + 5_000_000) / 1e9)


def test_events_and_attachments_come_back(recording):
    assert [event.kind for event in events(recording)] == [EventKind.STARTED]
    assert attachment(recording, "calibration.json") == CALIBRATION
    with pytest.raises(NotFound, match="it has: calibration.json"):
        attachment(recording, "other.json")


def test_empty_recording_is_sound(tmp_path):
    with RecordingWriter(tmp_path / "a.mcap"):
        pass
    assert list(frames(tmp_path / "a.mcap")) == []
    assert verify(tmp_path / "a.mcap").ok


@pytest.mark.parametrize(
    ("content", "seen"),
    [
        (b"", "empty file"),
        (b"not a recording at all, but text", "not MCAP"),
        (b"\x89MCAP0\r", "not MCAP"),
        (b"\x89MCAP0\r\n", "holds nothing"),
    ],
)
def test_file_that_is_no_recording_is_named(tmp_path, content, seen):
    path = tmp_path / "bad.mcap"
    path.write_bytes(content)
    for read in (lambda: list(frames(path)), lambda: info(path), lambda: verify(path)):
        with pytest.raises(RecordingUnreadable, match=seen) as caught:
            read()
        assert "\n" not in str(caught.value)


def test_missing_file_and_folder_are_unusable_input(tmp_path):
    for path in (tmp_path / "none.mcap", tmp_path):
        with pytest.raises(InputUnusable, match="give a recording"):
            info(path)


def test_recording_cut_anywhere_is_named(recording, rng):
    whole = recording.read_bytes()
    cuts = {9, 17, 18, 100, len(whole) - 1, len(whole) - 8, len(whole) - 37}
    cuts |= set(range(1000, len(whole), 1000)) | set(rng.integers(9, len(whole), 50).tolist())
    for cut in sorted(cuts):
        recording.write_bytes(whole[:cut])
        with pytest.raises(RecordingUnreadable, match=r"cut short or unfinished|holds nothing"):
            list(frames(recording))


def test_no_flipped_bit_is_believed(recording, rng):
    """Each of the file's regions and 300 random bits: named when verified, or when opened."""
    whole = recording.read_bytes()
    bits = {8 * 30, 8 * (len(whole) - 12), 8 * (len(whole) - 200)}
    bits |= set(rng.integers(0, 8 * len(whole), 300).tolist())
    for bit in sorted(bits):
        damaged = bytearray(whole)
        damaged[bit // 8] ^= 1 << bit % 8
        recording.write_bytes(damaged)
        try:
            report = verify(recording)
        except RecordingUnreadable:
            continue
        assert not report.ok, f"bit {bit % 8} of byte {bit // 8}"


def test_flipped_bit_in_a_picture_stops_the_reader_at_its_frame(recording, rng):
    pictures = list(frames(recording))
    whole = bytearray(recording.read_bytes())
    place = whole.index(pictures[2].picture.tobytes())
    whole[place + 100] ^= 1
    recording.write_bytes(whole)
    reader = frames(recording)
    assert [next(reader).frame_id, next(reader).frame_id] == [1, 2]
    with pytest.raises(RecordingUnreadable, match="damaged at byte"):
        next(reader)
    assert len(list(frames(recording, validate=False))) == 5


def test_gap_without_an_event_is_a_problem_and_with_one_is_a_loss(tmp_path, rng):
    for explained in (False, True):
        path = tmp_path / f"{explained}.mcap"
        with RecordingWriter(path) as writer:
            write_picture(writer, 1, picture(rng))
            if explained:
                event = Event(EventKind.FRAMES_LOST, START_NS, frame_id=2, count=2)
                writer.write_event("left", event)
            write_picture(writer, 4, picture(rng))
        report = verify(path)
        assert report.ok is explained
        assert report.lost == (2 if explained else 0)


def test_frame_id_that_runs_backward_is_a_problem(tmp_path, rng):
    with RecordingWriter(tmp_path / "a.mcap") as writer:
        write_picture(writer, 5, picture(rng))
        write_picture(writer, 4, picture(rng))
    assert "frame 4 follows frame 5" in verify(tmp_path / "a.mcap").problems[0]
