"""Whether the cameras of the settings answer."""

from ipaddress import AddressValueError, IPv4Address

from station.doctor.demand import Stream
from station.doctor.finding import Finding
from station.errors import InputUnusable
from station.simulated import Identity, probe_camera

_PATIENCE_S = 0.6


def find_camera(stream: Stream) -> Identity | None:
    """Ask a camera who it is; None where it does not answer.

    Raises
    ------
    InputUnusable
        If the settings hold no IPv4 address for it.
    """
    try:
        address = IPv4Address(stream.address)
    except AddressValueError as error:
        raise InputUnusable(
            f"sensor {stream.sensor}: address {stream.address!r} is not an IPv4 address ({error}); "
            "`station camera list` shows the cameras in reach"
        ) from error
    return probe_camera(address, timeout_s=_PATIENCE_S)


def judge_camera(stream: Stream, identity: Identity | None) -> Finding:
    """Judge whether a camera is there; it answers discovery whoever controls it."""
    name = f"camera {stream.sensor}"
    if identity is None:
        return Finding(
            name,
            f"nothing answers at {stream.address}",
            f"check its power and cable; station camera list --address {stream.address}",
        )
    return Finding(
        name, f"{identity.vendor} {identity.model} {identity.serial} answers at {stream.address}"
    )
