"""`station recording`: what is in a recording, whether it is sound, making it whole and small."""

from pathlib import Path
from typing import Annotated

import typer

from station.cli.output import AsJson, emit, progress_bar
from station.errors import NothingMeasurable
from station.progress import Progress
from station.recording import CompactReport, Event, RecordingInfo, events, whole_recordings
from station.recording import compact as compact_file
from station.recording import info as read_info
from station.recording import recover as recover_file
from station.recording import verify as verify_file

app = typer.Typer(
    help="Look at a recording, prove it, make it whole, make it small.", no_args_is_help=True
)

RecordingPath = Annotated[Path, typer.Argument(metavar="FILE", help="A recording (.mcap).")]

RecordingPaths = Annotated[
    list[Path], typer.Argument(metavar="FILE...", help="Recordings (.mcap), with all their files.")
]


@app.command()
def info(file: RecordingPath, as_json: AsJson = False) -> None:
    """Say what is in a recording."""
    found, happened = read_info(file), events(file)
    document = {**found.to_json(), "events": [event.to_json() for event in happened]}
    emit(document, _info_text(found, happened), as_json=as_json)


@app.command()
def verify(file: RecordingPath, as_json: AsJson = False) -> None:
    """Read all of a recording: every checksum, every frame, every frame id."""
    with progress_bar("verify") as progress:
        report = verify_file(file, progress)
    verdict = "sound" if report.ok else "; ".join(report.problems)
    text = f"{file}: {report.frames} frames, {report.lost} said to be lost: {verdict}"
    emit(report.to_json(), text, as_json=as_json)
    if not report.ok:
        raise NothingMeasurable(
            f"{file} is damaged ({len(report.problems)} problems, the first: "
            f"{report.problems[0]}); `station recording recover {file}` keeps what is sound"
        )


@app.command()
def recover(file: RecordingPath, as_json: AsJson = False) -> None:
    """Make an interrupted recording (.mcap.active) or a damaged one whole, in place."""
    report = recover_file(file)
    text = (
        f"{report.path}: {report.frames} frames, {report.cut_bytes} bytes cut off, "
        f"{report.damaged_chunks} damaged chunks hidden"
    )
    emit(report.to_json(), text, as_json=as_json)
    if not report.verified.ok:
        raise NothingMeasurable(
            f"{report.path} was made readable but is not sound: {report.verified.problems[0]}"
        )


@app.command()
def compact(files: RecordingPaths, as_json: AsJson = False) -> None:
    """Rewrite recordings smaller, in place, once every frame is proved equal; exit 1 if not all."""
    done: list[CompactReport] = []
    left: list[str] = []
    parts = [part for group in whole_recordings(files) for part in group]
    with progress_bar("compact") as progress:
        for place, part in enumerate(parts):
            try:
                done.append(compact_file(part, _step(progress, place, len(parts))))
            except NothingMeasurable as error:
                left.append(str(error))
    document = {"compacted": [one.to_json() for one in done], "left": left}
    if done or as_json:
        emit(document, "\n".join(map(_compact_text, done)), as_json=as_json)
    if left:
        raise NothingMeasurable("; ".join(left))


def _step(progress: Progress, place: int, count: int) -> Progress:
    """Return the progress of one of several."""
    return lambda part, what: progress((place + part) / count, what)


def _compact_text(report: CompactReport) -> str:
    before_mb, after_mb = report.before_bytes / 1e6, report.after_bytes / 1e6
    return (
        f"{report.path}: {before_mb:.1f} MB are now {after_mb:.1f} MB "
        f"({before_mb / after_mb:.2f} times smaller), {report.chunks} chunks proved equal"
    )


def _info_text(found: RecordingInfo, happened: list[Event]) -> str:
    lines = [f"{found.path}: {found.size_bytes / 1e6:.1f} MB, {found.duration_s:.1f} s"]
    lines += [
        f"sensor {one.sensor}: {one.frames} frames, {one.events} events" for one in found.sensors
    ]
    lines += [
        f"{name}: " + ", ".join(f"{key} {value}" for key, value in values.items())
        for name, values in found.metadata.items()
    ]
    lines += [f"attachment {name}: {size} bytes" for name, size in found.attachments.items()]
    return "\n".join(lines + [_event_text(event, found.start_ns) for event in happened])


def _event_text(event: Event, start_ns: int) -> str:
    at_s = (event.time_ns - start_ns) / 1e9
    place = "" if event.frame_id is None else f" at frame {event.frame_id}"
    count = f" ({event.count})" if event.count else ""
    return f"{at_s:9.3f} s {event.kind}{place}{count}: {event.detail}".rstrip(": ")
