"""`station camera`: the cameras in reach, and a simulated one to try the station with."""

from ipaddress import IPv4Address
from typing import Annotated

import typer

from station.cli.output import AsJson, emit
from station.cli.simulate import simulate
from station.errors import CameraError, CameraUnreachable
from station.simulated import Identity, parse_address, probe_camera

app = typer.Typer(
    help="Cameras in reach, and simulated ones.", no_args_is_help=True, rich_markup_mode=None
)


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


app.command()(simulate)


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
