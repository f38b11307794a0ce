"""Shows which frame is found: of a recording that grows the newest whole one, through all of its
files, and not more often than anybody can see."""

import contextlib
import os

import numpy as np
import pytest
from viewing_samples import HEIGHT, NOON_NS, WIDTH, striped, write_striped

from station.errors import NotFound, RecordingUnreadable
from station.recording import RecordingWriter, RotatingWriter, Rotation, active_path
from station.viewing import Form, SharedPicture, ViewOrder
from station.viewing.finding import Finder


class Clock:
    """Seconds that pass when the test says so."""

    def __init__(self):
        self.now_s = 0.0

    def __call__(self):
        return self.now_s

    def pass_on(self):
        self.now_s += 1.0


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def finder(clock):
    return Finder(clock)


def growing(path):
    return ViewOrder(Form.JPEG, path, growing=True)


def assert_found(found, number):
    assert (found.frame.number, found.frame.frame_id) == (number, 100 + number)
    assert found.frame.time_ns == NOON_NS + number * 1_000_000
    assert found.frame.received_ns == found.frame.time_ns + 5000
    np.testing.assert_array_equal(found.picture(), striped(number))


def test_the_newest_frame_is_found_while_a_recording_grows_and_when_it_has_ended(
    tmp_path, finder, clock
):
    path = tmp_path / "a.mcap"
    with pytest.raises(NotFound, match="no frame yet"):
        finder.find(growing(path))
    with RecordingWriter(path) as writer:
        for newest in (1, 4):
            write_striped(writer, range(max(1, newest - 2), newest + 1), "left")
            clock.pass_on()
            found = finder.find(growing(path))
            assert found.frame.frame_id == 100 + newest
        assert not path.exists()
    clock.pass_on()
    assert finder.find(growing(path)).frame == found.frame  # before the store knows that it ended
    assert finder.find(ViewOrder(Form.JPEG, path)).frame == found.frame


def test_the_newest_frame_is_counted_through_all_files_of_a_recording(tmp_path, finder, clock):
    path = tmp_path / "a.mcap"
    writer = RotatingWriter(path, "left", rotation=Rotation(size_bytes=1))
    for number in (1, 2, 3):
        write_striped(writer, [number])
        writer._wait_for_closing()
        clock.pass_on()
        assert_found(finder.find(growing(path)), number)
    writer.finish()
    assert_found(Finder(clock).find(growing(path)), 3)
    assert_found(finder.find(ViewOrder(Form.JPEG, path)), 3)
    for number in (1, 2, 3):
        assert_found(finder.find(ViewOrder(Form.JPEG, path, number=number)), number)
    with pytest.raises(NotFound, match="has 3 frames; there is no frame 4"):
        finder.find(ViewOrder(Form.JPEG, path, number=4))


def test_who_asks_soon_after_another_is_given_the_same_frame(tmp_path, finder, clock):
    path = tmp_path / "a.mcap"
    with RecordingWriter(path) as writer:
        write_striped(writer, [1], "left")
        assert_found(finder.find(growing(path)), 1)
        write_striped(writer, [2], "left")
        clock.now_s += 0.1
        assert_found(finder.find(growing(path)), 1)
        clock.now_s += 0.1
        assert_found(finder.find(growing(path)), 2)


def test_a_recording_whose_end_was_taken_back_is_read_anew(tmp_path, finder, clock):
    path = tmp_path / "a.mcap"
    with RecordingWriter(path) as writer:
        write_striped(writer, [1], "left")
        whole = active_path(path).stat().st_size
        write_striped(writer, [2], "left")
        finder.find(growing(path))
        os.truncate(active_path(path), whole)
        clock.pass_on()
        with pytest.raises(RecordingUnreadable, match="cut from"):
            finder.find(growing(path))
        assert_found(finder.find(growing(path)), 1)


def test_no_more_recordings_are_kept_open_than_a_station_has_in_use(tmp_path, finder, clock):
    paths = [tmp_path / f"{number}.mcap" for number in range(12)]
    for path in paths:
        with RecordingWriter(path) as writer:
            write_striped(writer, [1], "left")
    for _ in range(2):
        for path in paths:
            assert_found(finder.find(growing(path)), 1)
        clock.pass_on()
    assert len([name for name in _opened() if name.startswith(str(tmp_path))]) <= 8


def _opened():
    """Return what this process has open, by name."""
    names = []
    for each in os.listdir("/proc/self/fd"):
        with contextlib.suppress(FileNotFoundError):  # closed since it was listed
            names.append(os.readlink(f"/proc/self/fd/{each}"))
    return names


def test_a_shared_picture_is_read_where_it_lies(finder):
    descriptor = os.memfd_create("picture")
    try:
        os.write(descriptor, striped(5).tobytes())
        shared = SharedPicture(descriptor, WIDTH, HEIGHT, NOON_NS)
        found = finder.find(ViewOrder(Form.PNG, shared=shared))
        np.testing.assert_array_equal(found.picture(), striped(5))
    finally:
        os.close(descriptor)
    assert (found.frame.number, found.frame.frame_id) == (None, None)
    assert found.frame.received_ns == NOON_NS


def test_an_order_names_one_source():
    for arguments in ({}, {"recording": "a", "shared": SharedPicture(3, 1, 1, 0)}):
        with pytest.raises(ValueError, match="a recording or a shared picture"):
            ViewOrder(Form.PNG, **arguments)
