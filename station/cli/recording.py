"""`station recording`: what is in a recording, whether it is sound, and making it whole."""

from pathlib import Path
from typing import Annotated

import typer

from station.cli.output import AsJson, emit, progress_bar
from station.errors import NothingMeasurable
from station.recording import Event, RecordingInfo, events
from station.recording import info as read_info
from station.recording import recover as recover_file
from station.recording import verify as verify_file

app = typer.Typer(help="Look at a recording, prove it, make it whole.", no_args_is_help=True)

RecordingPath = Annotated[Path, typer.Argument(metavar="FILE", help="A recording (.mcap).")]


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
