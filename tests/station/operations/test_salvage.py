"""Shows what is taken from the file of a recording whose capture, or its report, was lost."""

import numpy as np
import pytest

from station.operations import salvage_recording
from station.operations.closing import Closed
from station.recording import ACCOUNTING, RecordingWriter

SAID = {
    "triggered": "None",
    "recorded": "3",
    "lost": "1",
    "refused": "0",
    "repeated": "2",
    "complete": "False",
}


def write(path, accounting):
    pixels = np.zeros((4, 4), np.uint8).data.cast("B")
    with RecordingWriter(path) as writer:
        for number in (1, 2, 4):
            writer.write_frame("left", number, number, number, pixels, 4, 4)
        if accounting is not None:
            writer.write_metadata(ACCOUNTING, accounting)


def closed(path, expected):
    return Closed.from_salvage(salvage_recording(path), expected, "no answer")


@pytest.mark.parametrize(
    ("accounting", "expected", "lost"),
    [
        (SAID, None, 1),
        (SAID, 6, 3),
        (SAID | {"triggered": "4"}, 4, 1),
    ],
)
def test_a_recording_that_was_finished_is_accounted_for_as_its_file_says(
    tmp_path, accounting, expected, lost
):
    path = tmp_path / "left.mcap"
    write(path, accounting)
    found = closed(path, expected)
    assert (found.recorded, found.lost, found.repeated) == (3, lost, 2)
    assert (found.recovered, found.complete) == (False, False)


def test_a_finished_recording_without_a_loss_is_complete(tmp_path):
    path = tmp_path / "left.mcap"
    write(path, SAID | {"lost": "0", "complete": "True"})
    assert closed(path, 3).complete
    assert not closed(path, 4).complete


@pytest.mark.parametrize(
    "accounting",
    [
        None,  # the capture died
        SAID | {"recorded": "4"},  # of other frames than are in it
        {"part": "1", "continued_in": "left.0002.mcap"},  # of one file, not of the recording
        SAID | {"lost": "some"},
    ],
)
def test_a_recording_that_was_cut_short_is_recovered_against_the_count(tmp_path, accounting):
    path = tmp_path / "left.mcap"
    write(path, accounting)
    found = closed(path, 5)
    assert (found.recorded, found.lost, found.recovered, found.complete) == (3, 2, True, False)
    assert found.summary == "no answer; 3 frames saved"


def test_nothing_left_is_said(tmp_path):
    found = closed(tmp_path / "left.mcap", None)
    assert (found.recorded, found.files, found.recovered) == (0, 0, False)
    assert found.summary == "no answer; nothing was left"
