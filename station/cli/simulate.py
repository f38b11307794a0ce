"""`station camera simulate`: be a camera until told to stop."""

import sys
import time
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from station.cli.output import AsJson, emit, progress_bar
from station.cli.view import Playing, View
from station.errors import InputUnusable
from station.processes.stop_signal import StopSignal
from station.scenes import Light
from station.simulated import (
    DeviceOptions,
    Faults,
    SceneKind,
    SimulatedCamera,
    Statistics,
    parse_address,
)

_LOOK_S = 0.2

_Address = Annotated[
    str, typer.Option(metavar="IP", help="Where the camera listens: any 127.x.y.z.")
]
_Scene = Annotated[SceneKind | None, typer.Option(help="Render what it looks at.")]
_Light = Annotated[Light, typer.Option(help="Light on the scene.")]
_Seed = Annotated[int, typer.Option(min=0, help="Draws the scenes and the faults.")]
_FramesPerScene = Annotated[
    int,
    typer.Option(
        min=1, max=64, metavar="N", help="Pictures of each scene: an exposure sequence's."
    ),
]
_Pictures = Annotated[
    Path | None, typer.Option(metavar="DIR", help="Serve the pictures of a folder.")
]
_Recording = Annotated[
    Path | None,
    typer.Option(
        "--from",
        metavar="FILE.mcap",
        help="Play a recording, all files of it, with its own timing and frame ids.",
    ),
]
_Sensor = Annotated[
    str | None, typer.Option(metavar="ID", help="Play this sensor's part of the recording.")
]
_Rate = Annotated[
    float | None,
    typer.Option(min=0.1, max=2000.0, metavar="F", help="Play so many pictures a second, evenly."),
]
_Once = Annotated[
    bool, typer.Option("--once", help="Play it once, and end when the receiver has stopped.")
]
_FrameRate = Annotated[
    float, typer.Option(min=0.1, max=2000.0, metavar="F", help="Pictures a second, free run.")
]
_Line1Rate = Annotated[
    float | None,
    typer.Option(min=0.01, max=2000.0, metavar="F", help="Raise the trigger line so often."),
]
_Probability = Annotated[float, typer.Option(min=0.0, max=1.0, metavar="P")]
_Serial = Annotated[str | None, typer.Option(metavar="S", help="Serial number.")]
_Seconds = Annotated[float | None, typer.Option(min=0.0, metavar="S", help="End after so long.")]


def simulate(
    address: _Address,
    scene: _Scene = None,
    light: _Light = Light.GOOD,
    seed: _Seed = 0,
    pictures: _Pictures = None,
    recording: _Recording = None,
    sensor: _Sensor = None,
    rate: _Rate = None,
    once: _Once = False,
    fps: _FrameRate = 53.0,
    line1_hz: _Line1Rate = None,
    packet_loss: _Probability = 0.0,
    frame_loss: _Probability = 0.0,
    serial: _Serial = None,
    seconds: _Seconds = None,
    frames_per_scene: _FramesPerScene = 1,
    as_json: AsJson = False,
) -> None:
    """Be a GigE Vision camera until Ctrl-C; it serves a rendered target where nothing is said."""
    view = View(
        scene, light, seed, pictures, Playing(recording, sensor, once, rate), frames_per_scene
    )
    if recording is not None and line1_hz is not None:
        raise InputUnusable("--line1-hz with --from: a recording is its own trigger; give --rate")
    parse_address(address)
    with progress_bar("rendering") as progress:
        source = view.open(progress)
    camera = SimulatedCamera(
        address,
        source,
        serial=serial,
        faults=Faults(packet_loss=packet_loss, frame_loss=frame_loss, seed=seed),
        options=DeviceOptions(frame_rate_hz=fps),
    )
    with StopSignal() as stop, camera:
        # The document on stdout comes at the end; a script waits for this line on stderr.
        print(
            f"camera {camera.serial} at {address}: {source.width} × {source.height} px, "
            f"{view.pace or f'{fps:g} pictures a second'}, {view.name}",
            file=sys.stderr if as_json else sys.stdout,
            flush=True,
        )
        _stand_by(camera, stop, seconds=seconds, line1_hz=line1_hz)
    statistics = camera.statistics()
    emit(asdict(statistics), _summary(statistics), as_json=as_json)


def _stand_by(
    camera: SimulatedCamera,
    stop: StopSignal,
    *,
    seconds: float | None,
    line1_hz: float | None,
) -> None:
    """Raise the trigger line in its rhythm until told to end, or there is nothing more to do."""
    begun_s, begun_ns = time.monotonic(), time.time_ns()
    period_s = _LOOK_S if line1_hz is None else 1.0 / line1_hz
    count = 0
    while camera.failure is None and not camera.played_out:
        count += 1
        due_s = count * period_s
        if seconds is not None and due_s > seconds:
            stop.wait(max(0.0, begun_s + seconds - time.monotonic()))
            return
        if stop.wait(max(0.0, begun_s + due_s - time.monotonic())):
            return
        if line1_hz is not None:
            camera.trigger_line1(begun_ns + round(due_s * 1e9))


def _summary(statistics: Statistics) -> str:
    return (
        f"{statistics.exposed} pictures taken, {statistics.sent} sent, "
        f"{statistics.lost_frames} lost; {statistics.dropped_packets} packets dropped, "
        f"{statistics.resent_packets} sent again; {statistics.missed_triggers} triggers missed"
    )
