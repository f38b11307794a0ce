"""Files that are no sound recordings, given to the commands: named in one line, none is believed.

The commands run in this process: starting the program for each file would take minutes.  What a
flipped bit does inside the reader is shown at more places in the tests of the recording.
"""

import json
import re
from datetime import UTC, datetime

import numpy as np
import pytest

from station.cli.main import build_app, run
from station.documents import CalibrationDocument
from station.recording import Event, EventKind, RecordingWriter, active_path, frames

WIDTH, HEIGHT, FRAMES = 64, 48, 5
READING = ("info", "verify", "measure", "calibrate")
WHAT_IS_WRONG = "damaged|cut short or unfinished|holds nothing|not MCAP|an empty file|none of its"


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A sound recording's bytes."""
    path = tmp_path_factory.mktemp("whole") / "a.mcap"
    rng = np.random.default_rng(4)
    metadata = {"camera": {"sensor": "left", "exposure_us": "250.0"}}
    with RecordingWriter(path, metadata=metadata, attachments={"notes.txt": b"a pass"}) as writer:
        writer.write_event("left", Event(EventKind.STARTED, 1, "a pass"))
        for number in range(1, FRAMES + 1):
            picture = rng.integers(0, 256, (HEIGHT, WIDTH), dtype=np.uint8)
            view = picture.data.cast("B")
            writer.write_frame("left", number, number, number, view, WIDTH, HEIGHT)
        writer.write_metadata("accounting", {"recorded": "5"})
    return path.read_bytes()


@pytest.fixture(scope="module")
def calibration(tmp_path_factory):
    """A calibration for pictures of that size."""
    path = tmp_path_factory.mktemp("calibration") / "calibration.json"
    CalibrationDocument.model_validate({
        "sensor": "left",
        "created": datetime(2026, 1, 1, tzinfo=UTC),
        "software": "none",
        "method": "joint",
        "camera": {"fx": 60, "fy": 60, "cx": 32, "cy": 24, "width": WIDTH, "height": HEIGHT},
        "plane": {"a": 0.0, "b": 0.6, "c": 0.8, "d": 500.0},
        "plane_covariance": [[0.0] * 4] * 4,
        "rms": {"dots_px": 0.1, "stripe_px": 0.1},
        "poses": [],
        "quality": {},
        "options": {},
        "inputs": [],
        "mounting": {"rotation_vector": [0.0, 0.0, 0.0], "translation_mm": [0.0, 0.0, 0.0]},
    }).write(path)
    return path


@pytest.fixture
def path(tmp_path):
    return tmp_path / "a.mcap"


@pytest.fixture
def command(path, calibration, capsys):
    """Run a command on the recording; return its exit code and what it said."""
    rest = {
        "measure": ["--calibration", str(calibration)],
        "calibrate": ["--target", "dots:7x8:12", "--out", str(path.with_name("out.json"))],
    }

    def run_on(name, file=path):
        words = [name, str(file), *rest[name]] if name in rest else ["recording", name, str(file)]
        code = run(build_app(words[0]), [*words, "--json"] if name in {"info", "verify"} else words)
        said = capsys.readouterr()
        assert "Traceback" not in said.err
        return code, said.out, said.err

    return run_on


def named(path, code, said):
    """Whether a refusal is one line that names the file and what is wrong with it."""
    one_line = said.count("\n") == 1 and said.startswith("station: ")
    return code in {1, 2} and one_line and str(path) in said and re.search(WHAT_IS_WRONG, said)


def test_sound_recording_is_not_called_damaged(command, path, whole):
    """So that what follows shows something: without damage the commands say other things."""
    path.write_bytes(whole)
    assert command("info")[0] == command("verify")[0] == 0
    for name, seen in (("measure", "wheels could be measured"), ("calibrate", "0 usable pictures")):
        _, _, said = command(name)
        assert seen in said, said
        assert not re.search(WHAT_IS_WRONG, said)


@pytest.mark.parametrize(
    "content", [b"", b"no recording, but text", b"\x89MCAP0\r", b"\x89MCAP0\r\n", bytes(5000)]
)
@pytest.mark.parametrize("name", [*READING, "recover", "compact"])
def test_file_that_is_no_recording_is_named(command, path, name, content):
    path.write_bytes(content)
    code, out, said = command(name)
    assert code == 2
    assert named(path, code, said), said
    assert not out
    assert path.read_bytes() == content


@pytest.mark.parametrize("name", READING)
def test_recording_cut_at_every_kilobyte_is_named(command, path, whole, name):
    for size in range(1000, len(whole), 1000):
        path.write_bytes(whole[:size])
        code, out, said = command(name)
        assert code == 2
        assert named(path, code, said), (size, said)
        assert not out


def test_recording_cut_at_every_kilobyte_is_recovered_or_named(command, path, whole):
    path.write_bytes(whole)
    pictures = [frame.picture for frame in frames(path)]
    path.unlink()
    for size in range(1000, len(whole), 1000):
        active_path(path).write_bytes(whole[:size])
        code, _, said = command("recover", active_path(path))
        if code == 2:
            assert named(active_path(path), code, said), (size, said)
            active_path(path).unlink()
            continue
        assert command("verify")[0] == code == 0, said
        kept = [frame.picture for frame in frames(path)]
        np.testing.assert_array_equal(kept, pictures[: len(kept)])
        path.unlink()


def flipped(whole, bit):
    damaged = bytearray(whole)
    damaged[bit // 8] ^= 1 << bit % 8
    return bytes(damaged)


@pytest.fixture
def bits(rng, whole):
    """Twenty anywhere, and one in each of the places that hold no picture."""
    places = (b"exposure_us", b"250.0", b"a pass", b"recorded", b"/left/image")
    return [8 * whole.index(place) + 1 for place in places] + [
        int(bit) for bit in rng.integers(0, 8 * len(whole), 20)
    ]


@pytest.mark.parametrize("name", ["verify", "measure", "calibrate", "compact"])
def test_recording_with_one_flipped_bit_is_named(command, path, whole, bits, name):
    for bit in bits:
        path.write_bytes(flipped(whole, bit))
        code, _, said = command(name)
        assert named(path, code, said), (bit, code, said)


def test_info_of_a_recording_with_one_flipped_bit_is_right_or_refused(command, path, whole, bits):
    """A bit of a picture changes nothing of what it says; any other is named."""
    path.write_bytes(whole)
    right = json.loads(command("info")[1])
    for bit in bits:
        path.write_bytes(flipped(whole, bit))
        code, out, said = command("info")
        assert named(path, code, said) or json.loads(out) == right, (bit, said)


def test_recovering_a_recording_with_one_flipped_bit_keeps_what_is_sound(
    command, path, whole, bits
):
    path.write_bytes(whole)
    pictures = {frame.frame_id: frame.picture for frame in frames(path)}
    for bit in bits:
        path.write_bytes(flipped(whole, bit))
        code, _, said = command("recover")
        if code == 2:
            assert named(path, code, said), (bit, said)
            continue
        for frame in frames(path):
            np.testing.assert_array_equal(frame.picture, pictures[frame.frame_id])
