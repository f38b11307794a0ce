"""`station record`: frames of one camera into a recording, each accounted for."""

import tempfile
import time
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from station.capture import (
    CaptureClient,
    CaptureReport,
    CaptureState,
    RecordingPlan,
    Trigger,
    start_capture,
)
from station.cli.output import AsJson, emit, progress_bar
from station.errors import InputUnusable, NothingMeasurable
from station.progress import Progress
from station.recording import Rotation
from station.settings import SensorSettings

_LOOK_INTERVAL_S = 0.1
_END_TIMEOUT_S = 10.0


def record(
    camera: Annotated[str, typer.Option(metavar="ADDRESS", help="IP address of the camera.")],
    out: Annotated[Path, typer.Option(metavar="FILE.mcap", help="Recording to write.")],
    frames: Annotated[int | None, typer.Option(min=1, help="Stop after so many frames.")] = None,
    seconds: Annotated[float | None, typer.Option(help="Stop after so many seconds.")] = None,
    trigger: Annotated[Trigger, typer.Option(help="What starts an exposure.")] = Trigger.FREE,
    sensor: Annotated[str, typer.Option(metavar="ID", help="Name of the sensor.")] = "camera",
    exposure: Annotated[
        float | None, typer.Option(metavar="US", help="Exposure time, us; else the camera's own.")
    ] = None,
    rotate: Annotated[
        float | None,
        typer.Option(metavar="S", help="Go on in a next file every S seconds; else in one file."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Record frames of a camera; exit 1 where any is missing."""
    plan = _plan(out, sensor, trigger, frames, seconds, rotate)
    settings = _settings(sensor, camera, trigger, exposure)
    with _capture(settings) as client, progress_bar("record") as progress:
        client.arm(plan)
        _watch(client, plan, progress)
        report = client.finish()
    emit(report.to_json(), report.summary(), as_json=as_json)
    _judge(report)


def _plan(
    out: Path,
    sensor: str,
    trigger: Trigger,
    frames: int | None,
    seconds: float | None,
    rotate_s: float | None,
) -> RecordingPlan:
    if (frames is None) == (seconds is None):
        raise InputUnusable("how much to record: give --frames N or --seconds S, one of the two")
    if seconds is not None and not (seconds > 0.0):
        raise InputUnusable(f"--seconds {seconds:g}: give more than 0")
    if rotate_s is not None and not (rotate_s > 0.0):
        raise InputUnusable(f"--rotate {rotate_s:g}: give more than 0")
    if out.suffix != ".mcap":
        raise InputUnusable(f"{out}: a recording's name ends in .mcap")
    if out.exists():
        raise InputUnusable(f"{out} exists; recordings are not overwritten: choose a new name")
    return RecordingPlan(
        session_id=out.stem,
        path=out.absolute(),
        sensor=sensor,
        trigger=trigger,
        frames=frames,
        seconds=seconds,
        rotation=Rotation(rotate_s),
    )


def _settings(
    sensor: str, camera: str, trigger: Trigger, exposure_us: float | None
) -> SensorSettings:
    try:
        return SensorSettings(
            id=sensor, address=camera, trigger=trigger.value, exposure_us=exposure_us
        )
    except ValueError as error:  # pydantic's, over several lines
        raise InputUnusable(
            f"--sensor {sensor} --exposure {exposure_us}: a sensor's name has lower-case letters, "
            "digits, - and _; an exposure is more than 0"
        ) from error


@contextmanager
def _capture(settings: SensorSettings) -> Generator[CaptureClient, None, None]:
    """Run a capture process for this command alone."""
    with tempfile.TemporaryDirectory(prefix="treadline-") as folder:
        socket_path = Path(folder) / "capture.sock"
        process = start_capture(settings, socket_path)
        try:
            yield CaptureClient(socket_path)
        finally:
            process.terminate()
            process.join(_END_TIMEOUT_S)
            if process.is_alive():
                process.kill()
                process.join()


def _watch(client: CaptureClient, plan: RecordingPlan, progress: Progress) -> None:
    """Wait until the plan is done; Ctrl-C ends the recording there, whole."""
    start_s = time.monotonic()
    try:
        while (status := client.status()).state is not CaptureState.RECORDED:
            # All may be there though the file is not closed yet: one more would come too late.
            accounted = status.recorded + status.lost + status.refused
            wanted = plan.frames is None or accounted < plan.frames
            if plan.trigger is Trigger.SOFTWARE and wanted:
                client.trigger()
            else:
                time.sleep(_LOOK_INTERVAL_S)
            if plan.frames is not None:
                done = status.recorded / plan.frames
            else:
                done = (time.monotonic() - start_s) / (plan.seconds or 1.0)
            progress(min(done, 1.0), f"{status.recorded} frames, {status.lost} lost")
    except KeyboardInterrupt:
        progress(1.0, "interrupted")


def _judge(report: CaptureReport) -> None:
    if report.complete:
        return
    missing = report.lost + report.refused
    raise NothingMeasurable(
        f"{missing} frames are missing from {report.path} ({report.recorded} are in it): look at "
        "its events with `station recording info`, and at this host with `station doctor`"
    )
