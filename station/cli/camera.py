"""`station camera`: the cameras in reach, and a simulated one to try the station with."""

import signal
import sys
import threading
import time
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from ipaddress import IPv4Address
from pathlib import Path
from typing import Annotated

import typer

from station.cli.output import AsJson, emit, progress_bar
from station.errors import CameraError, CameraUnreachable, InputUnusable
from station.progress import Progress
from station.scenes import Light
from station.simulated import (
    DeviceOptions,
    Faults,
    FrameSource,
    Identity,
    PictureFolder,
    RecordingSource,
    SceneKind,
    SimulatedCamera,
    Statistics,
    parse_address,
    probe_camera,
    render_scenes,
)

app = typer.Typer(
    help="Cameras in reach, and simulated ones.", no_args_is_help=True, rich_markup_mode=None
)

_LOOK_S = 0.2
_Probability = typer.Option(min=0.0, max=1.0, metavar="P")


@app.command("list")
def list_cameras(
    address: Annotated[
        list[str] | None,
        typer.Option(metavar="IP", help="Ask this address too; may be given more than once."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List the cameras that answer a search of the local networks."""
    wanted = [parse_address(text) for text in address or ()]
    found = {camera.address: camera for camera in _search()}
    for each in wanted:
        identity = found.get(each) or probe_camera(each)
        if identity is None:
            raise CameraUnreachable(
                f"no camera answers at {each}; check its power, its cable and the address, "
                "or start one by `station camera simulate`"
            )
        found[each] = identity
    cameras = [found[each] for each in sorted(found)]
    lines = [
        f"{camera.address}  {camera.serial}  {camera.vendor} {camera.model}  {camera.user_name}"
        for camera in cameras
    ]
    text = "\n".join(line.rstrip() for line in lines) or "no camera answers"
    emit([_described(camera) for camera in cameras], text, as_json=as_json)


@app.command()
def simulate(
    address: Annotated[
        str, typer.Option(metavar="IP", help="Where the camera listens: any 127.x.y.z.")
    ],
    scene: Annotated[SceneKind | None, typer.Option(help="Render what it looks at.")] = None,
    light: Annotated[Light, typer.Option(help="Light on the scene.")] = Light.GOOD,
    seed: Annotated[int, typer.Option(min=0, help="Draws the scenes and the faults.")] = 0,
    pictures: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Serve the pictures of a folder.")
    ] = None,
    recording: Annotated[
        Path | None,
        typer.Option(
            "--from",
            metavar="FILE.mcap",
            help="Play a recording, all files of it, with its own timing and frame ids.",
        ),
    ] = None,
    sensor: Annotated[
        str | None, typer.Option(metavar="ID", help="Play this sensor's part of the recording.")
    ] = None,
    rate: Annotated[
        float | None,
        typer.Option(
            min=0.1, max=2000.0, metavar="F", help="Play so many pictures a second, evenly."
        ),
    ] = None,
    once: Annotated[
        bool,
        typer.Option("--once", help="Play it once, and end when the receiver has stopped."),
    ] = False,
    fps: Annotated[
        float, typer.Option(min=0.1, max=2000.0, metavar="F", help="Pictures a second, free run.")
    ] = 53.0,
    line1_hz: Annotated[
        float | None,
        typer.Option(min=0.01, max=2000.0, metavar="F", help="Raise the trigger line so often."),
    ] = None,
    packet_loss: Annotated[float, _Probability] = 0.0,
    frame_loss: Annotated[float, _Probability] = 0.0,
    serial: Annotated[str | None, typer.Option(metavar="S", help="Serial number.")] = None,
    seconds: Annotated[
        float | None, typer.Option(min=0.0, metavar="S", help="End after so long.")
    ] = None,
    frames_per_scene: Annotated[
        int,
        typer.Option(
            min=1, max=64, metavar="N", help="Pictures of each scene: an exposure sequence's."
        ),
    ] = 1,
    as_json: AsJson = False,
) -> None:
    """Be a GigE Vision camera until Ctrl-C; it serves a rendered target where nothing is said."""
    playing = _Playing(recording, sensor, once, rate)
    choice = _Choice(scene, light, seed, pictures, playing, frames_per_scene)
    if recording is not None and line1_hz is not None:
        raise InputUnusable("--line1-hz with --from: a recording is its own trigger; give --rate")
    parse_address(address)
    with progress_bar("rendering") as progress:
        source = choice.open(progress)
    camera = SimulatedCamera(
        address,
        source,
        serial=serial,
        faults=Faults(packet_loss=packet_loss, frame_loss=frame_loss, seed=seed),
        options=DeviceOptions(frame_rate_hz=fps),
    )
    with _interruption() as ended, camera:
        # The document on stdout comes at the end; a script waits for this line on stderr.
        print(
            f"camera {camera.serial} at {address}: {source.width} × {source.height} px, "
            f"{choice.pace or f'{fps:g} pictures a second'}, {choice.name}",
            file=sys.stderr if as_json else sys.stdout,
            flush=True,
        )
        _stand_by(camera, ended, seconds=seconds, line1_hz=line1_hz)
    statistics = camera.statistics()
    emit(asdict(statistics), _summary(statistics), as_json=as_json)


@dataclass(frozen=True, slots=True)
class _Playing:
    """How a recording is to be played, if one is."""

    path: Path | None
    sensor: str | None
    once: bool
    rate_hz: float | None

    def __post_init__(self) -> None:
        if self.path is None and (self.sensor or self.once or self.rate_hz):
            raise InputUnusable(
                "--sensor, --once and --rate say how to play; give --from FILE.mcap"
            )

    @property
    def pace(self) -> str:
        return f"{self.rate_hz:g} pictures a second" if self.rate_hz else "its own timing"

    def open(self) -> RecordingSource | None:
        if self.path is None:
            return None
        return RecordingSource(self.path, self.sensor, once=self.once, rate_hz=self.rate_hz)


@dataclass(frozen=True, slots=True)
class _Choice:
    """What the camera is to look at."""

    scene: SceneKind | None
    light: Light
    seed: int
    pictures: Path | None
    playing: _Playing
    frames_per_scene: int

    def __post_init__(self) -> None:
        given = [self.scene, self.pictures, self.playing.path]
        if len(given) - given.count(None) > 1:
            raise InputUnusable("a camera looks at one thing: --scene, --pictures or --from")

    @property
    def name(self) -> str:
        if self.pictures or self.playing.path:
            return f"from {self.pictures or self.playing.path}"
        return f"{self.scene or SceneKind.TARGET} in {self.light} light"

    @property
    def pace(self) -> str | None:
        return self.playing.pace if self.playing.path else None

    def open(self, progress: Progress) -> FrameSource:
        if self.pictures:
            return PictureFolder(self.pictures)
        played = self.playing.open()
        if played is not None:
            return played
        kind = self.scene or SceneKind.TARGET
        return render_scenes(
            kind,
            self.light,
            seed=self.seed,
            progress=progress,
            frames_per_scene=self.frames_per_scene,
        )


@contextmanager
def _interruption() -> Generator[threading.Event]:
    """Yield an event that Ctrl-C and SIGTERM set, instead of ending the program at once."""
    ended = threading.Event()
    kinds = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(kind, lambda *_: ended.set()) for kind in kinds]
    try:
        yield ended
    finally:
        for kind, handler in zip(kinds, before, strict=True):
            signal.signal(kind, handler)


def _stand_by(
    camera: SimulatedCamera,
    ended: threading.Event,
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
            ended.wait(max(0.0, begun_s + seconds - time.monotonic()))
            return
        if ended.wait(max(0.0, begun_s + due_s - time.monotonic())):
            return
        if line1_hz is not None:
            camera.trigger_line1(begun_ns + round(due_s * 1e9))


def _search() -> list[Identity]:
    """Return the GigE Vision cameras that Aravis finds; it takes a second."""
    try:
        # Aravis costs 0.1 s to load, and is not needed to simulate a camera.
        import gi  # noqa: PLC0415

        gi.require_version("Aravis", "0.8")
        from gi.repository import Aravis  # noqa: PLC0415
    except (ImportError, ValueError) as error:
        raise CameraError(
            f"Aravis is missing ({error}); install it: apt-get install gir1.2-aravis-0.8"
        ) from error
    Aravis.update_device_list()
    found = range(Aravis.get_n_devices())
    addresses = [
        Aravis.get_device_address(i) for i in found if Aravis.get_device_protocol(i) == "GigEVision"
    ]
    # Asked once more, a camera says more of itself than Aravis passes on.
    identities = [probe_camera(IPv4Address(address)) for address in addresses]
    return [identity for identity in identities if identity is not None]


def _described(camera: Identity) -> dict[str, str]:
    return {
        "address": str(camera.address),
        "serial": camera.serial,
        "vendor": camera.vendor,
        "model": camera.model,
        "version": camera.version,
        "name": camera.user_name,
    }


def _summary(statistics: Statistics) -> str:
    return (
        f"{statistics.exposed} pictures taken, {statistics.sent} sent, "
        f"{statistics.lost_frames} lost; {statistics.dropped_packets} packets dropped, "
        f"{statistics.resent_packets} sent again; {statistics.missed_triggers} triggers missed"
    )
