"""Space is asked for before a recording begins, with the numbers that were compared."""

import pytest

from station.errors import DiskFull
from station.settings import SensorSettings, StorageSettings
from station.storage import Expected, ensure_space, expected_of_pass, expected_of_session

PICTURE = 2048 * 1088


def sensor(**settings):
    return SensorSettings(id="left", address="127.10.0.1", **settings)


def test_free_running_sensor_takes_its_rate_for_the_longest_pass():
    storage = StorageSettings(longest_pass_s=30.0)
    expected = expected_of_pass(sensor(trigger="free", frame_rate_hz=50.0), storage, PICTURE)
    assert expected.frames == 1500
    # 512 bytes a frame beside the picture.
    assert expected.size_bytes == 1500 * (PICTURE + 512)


def test_triggered_sensor_takes_a_frame_an_axle():
    assert expected_of_pass(sensor(), StorageSettings(most_axles=12), PICTURE).frames == 12


def test_camera_that_does_not_say_its_size_is_taken_for_the_largest():
    asked = expected_of_session(sensor(), StorageSettings(most_poses=1), None)
    assert asked.size_bytes == PICTURE + 512


def test_what_fits_to_the_byte_is_let_pass_and_one_less_is_not(tmp_path):
    expected = [Expected("left", 10, 3_000_000_000), Expected("right", 10, 2_000_000_000)]
    needed = 5_000_000_000 + 1_500_000_000
    ensure_space(tmp_path, expected, 1.5, "a pass", free_of=lambda _: needed)
    with pytest.raises(DiskFull) as refused:
        ensure_space(tmp_path, expected, 1.5, "a pass", free_of=lambda _: needed - 1)
    said = str(refused.value)
    assert "\n" not in said
    for number in ("6.50 GB", "left 10 frames, 3.00 GB", "right 10 frames, 2.00 GB", "1.5 GB"):
        assert number in said


def test_recorded_frame_takes_no_more_than_is_asked_for(tmp_path):
    """So that what is asked for is enough: measured on a recording."""
    from station.recording import RecordingWriter  # noqa: PLC0415  beside its only use

    path, count = tmp_path / "a.mcap", 200
    with RecordingWriter(path, attachments={"calibration.json": bytes(20_000)}) as writer:
        for number in range(1, count + 1):
            writer.write_frame("left", number, number, number, memoryview(bytes(100)), 10, 10)
    assert (
        path.stat().st_size
        < expected_of_session(sensor(), StorageSettings(most_poses=count), 100).size_bytes + 50_000
    )
