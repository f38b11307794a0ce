"""Files that are no recordings, or damaged ones: each named, none believed, nothing crashes."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from station.bench.figures import Row, none_of
from station.errors import StationError
from station.progress import Progress
from station.recording import (
    Event,
    EventKind,
    RecordingWriter,
    events,
    frames,
    info,
    verify,
)
from station.tables import Table

_SENSOR = "bench"
_FRAMES, _WIDTH, _HEIGHT = 12, 96, 64
_FLIPS = 20
_MAGIC_BYTES = 8
_KILOBYTE = 1000


def bench_bad_files(progress: Progress, folder: Path) -> Table:
    """Read spoilt copies of a sound recording by all that read recordings."""
    sound = _sound_recording(folder / "sound.mcap")
    content = sound.read_bytes()
    counts: dict[str, list[bool | None]] = {}
    spoilt = list(_spoilt(content))
    for place, (kind, data) in enumerate(spoilt):
        progress(place / len(spoilt), kind)
        path = folder / "spoilt.mcap"
        path.write_bytes(data)
        counts.setdefault(kind, []).append(_named(path))
    rows: list[Row] = []
    for kind, outcomes in counts.items():
        rows += [
            none_of(f"{kind}, {len(outcomes)} files: crashes", outcomes.count(None)),
            none_of(f"{kind}, {len(outcomes)} files: believed", outcomes.count(False)),
        ]
    assured = verify(sound).ok and len(list(frames(sound))) == _FRAMES
    rows.append(none_of("the sound file itself refused", 0 if assured else 1))
    note = (
        f"Copies of a recording of {len(content)} bytes; each is read by info, verify, and frame "
        "by frame."
    )
    return Table("Bad files", rows, (note,))


def _named(path: Path) -> bool | None:
    """Whether somebody says what is wrong with a file; None where one of its readers crashes."""
    readers: tuple[Callable[[Path], object], ...] = (info, events, lambda path: [*frames(path)])
    named = False
    try:
        for read in readers:
            try:
                read(path)
            except StationError:
                named = True
        try:
            named |= not verify(path).ok
        except StationError:
            named = True
    except Exception:  # noqa: BLE001  whatever it is, it is what this bench counts
        return None
    return named


def _spoilt(content: bytes) -> Iterator[tuple[str, bytes]]:
    yield "not MCAP", b"P5 96 64 255\n" + bytes(_WIDTH * _HEIGHT)
    yield "empty", b""
    yield "signature only", content[:_MAGIC_BYTES]
    for length in range(_KILOBYTE, len(content), _KILOBYTE):
        yield "cut at every kilobyte", content[:length]
    rng = np.random.default_rng(20)
    for bit in rng.integers(0, 8 * len(content), _FLIPS):
        flipped = bytearray(content)
        flipped[bit // 8] ^= 1 << (bit % 8)
        yield "one bit flipped", bytes(flipped)


def _sound_recording(path: Path) -> Path:
    rng = np.random.default_rng(1)
    start_ns = 1_700_000_000_000_000_000
    with RecordingWriter(path, metadata={"session": {"id": "bad files"}}) as writer:
        writer.write_event(_SENSOR, Event(EventKind.STARTED, start_ns, "bad files"))
        for place in range(_FRAMES):
            pixels = rng.integers(0, 256, _WIDTH * _HEIGHT, dtype=np.uint8)
            at_ns = start_ns + place * 18_622_000
            view = memoryview(pixels.tobytes())
            writer.write_frame(_SENSOR, place + 1, at_ns, at_ns, view, _WIDTH, _HEIGHT)
        writer.write_event(_SENSOR, Event(EventKind.FINISHED, at_ns, "bad files"))
    return path
