"""`station import`: pictures and folders of pictures into a recording."""

import time
from pathlib import Path
from typing import Annotated

import typer

from station.cli.options import Sources
from station.cli.output import AsJson, emit, progress_bar
from station.errors import InputUnusable
from station.pictures import RECORDING_SUFFIX, pictures_of, read_picture
from station.progress import Progress
from station.recording import RecordingWriter
from station.settings import SensorSettings
from station.software import SOFTWARE


def import_sources(
    sources: Sources,
    out: Annotated[Path, typer.Option(metavar="FILE.mcap", help="Recording to write.")],
    sensor: Annotated[str, typer.Option(metavar="ID", help="Name of the sensor.")] = "camera",
    as_json: AsJson = False,
) -> None:
    """Put pictures into a recording, in the order given; a frame's time is its file's."""
    _check(out, sensor)
    pictures = [path for source in sources for path in _pictures_of(source)]
    with progress_bar("import") as progress:
        _write(pictures, out, sensor, progress)
    text = f"{out}: {len(pictures)} pictures as frames 1 to {len(pictures)} of sensor {sensor}"
    emit({"path": str(out), "sensor": sensor, "frames": len(pictures)}, text, as_json=as_json)


def _check(out: Path, sensor: str) -> None:
    if out.suffix != RECORDING_SUFFIX:
        raise InputUnusable(f"{out}: a recording's name ends in {RECORDING_SUFFIX}")
    try:
        SensorSettings(id=sensor, address="")
    except ValueError as error:  # pydantic's, over several lines
        raise InputUnusable(
            f"--sensor {sensor}: a sensor's name has lower-case letters, digits, - and _"
        ) from error


def _pictures_of(source: Path) -> list[Path]:
    if source.suffix.lower() == RECORDING_SUFFIX:
        raise InputUnusable(f"{source} is a recording already; give pictures or folders of them")
    return pictures_of(source)


def _write(pictures: list[Path], out: Path, sensor: str, progress: Progress) -> None:
    """Write all pictures; one that cannot be read leaves no recording behind."""
    names = {str(number): path.name for number, path in enumerate(pictures, 1)}
    metadata = {"station": {"software": SOFTWARE}, "import": names}
    writer = RecordingWriter(out, metadata=metadata)
    try:
        for number, path in enumerate(pictures, 1):
            picture = read_picture(path)
            height, width = picture.shape
            pixels = picture.data.cast("B")
            taken_ns = path.stat().st_mtime_ns
            writer.write_frame(sensor, number, taken_ns, time.time_ns(), pixels, width, height)
            progress(number / len(pictures), path.name)
    except InputUnusable:
        writer.discard()
        raise
    writer.finish()
