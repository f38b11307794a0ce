"""The examination: every check, one after the other."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from station.doctor import buffers, cameras, clock, disk, machine, route, software
from station.doctor.demand import Stream
from station.doctor.finding import Finding
from station.doctor.host import Host
from station.progress import Progress, silent
from station.settings import StationSettings, StorageSettings

_USUAL = Stream("camera", "", packet_size=9000, frame_rate_hz=53.0, ring_slots=128)
"""What a station without settings is judged for."""


@dataclass(frozen=True, slots=True)
class Patient:
    """What is examined: a host, the folder of its recordings, the cameras it will have."""

    folder: Path
    streams: Sequence[Stream] = (_USUAL,)
    storage: StorageSettings = field(default_factory=StorageSettings)
    host: Host = field(default_factory=Host)

    @classmethod
    def of(cls, settings: StationSettings) -> "Patient":
        """Return what the settings ask for."""
        streams = tuple(Stream.of(sensor) for sensor in settings.sensors)
        return cls(settings.data_dir, streams, settings.storage)


def examine(patient: Patient, progress: Progress = silent) -> list[Finding]:
    """Make every check; it takes some seconds, most of them for the disk.

    Nothing is changed: no setting, no camera, and the trial's file is gone afterwards.

    Raises
    ------
    InputUnusable
        If the folder or a camera's address cannot be used.
    """
    found = []
    for finding in _findings(patient):
        found.append(finding)
        progress(len(found) / (13 + 3 * len(patient.streams)), finding.name)
    return found


def _findings(patient: Patient) -> Iterator[Finding]:
    host, streams = patient.host, patient.streams
    folder = disk.existing_folder(patient.folder)
    yield software.judge_packages()
    yield software.judge_aravis(software.probe_aravis())
    yield machine.judge_processors(machine.own_cores(), streams)
    yield machine.judge_governor(host)
    yield machine.judge_memory(host, streams)
    yield machine.judge_shared_memory(host)
    yield machine.judge_limits(*machine.own_limits())
    yield clock.judge_clock(clock.clock_state())
    rights = buffers.Rights.of(host)
    yield buffers.judge_receive_buffer(buffers.granted_bytes(), rights, host, streams)
    yield buffers.judge_backlog(host, streams)
    yield from _networks([stream for stream in streams if stream.on_network], host)
    yield disk.judge_space(folder, streams, patient.storage)
    yield disk.judge_quota(folder, patient.storage)
    yield disk.judge_speed(disk.write_speed(folder), folder, streams)


def _networks(streams: Sequence[Stream], host: Host) -> Iterator[Finding]:
    rates: defaultdict[tuple[str, int], float] = defaultdict(float)
    for stream in streams:
        yield cameras.judge_camera(stream, cameras.find_camera(stream))
        try:
            way = route.probe_route(stream, host)
        except OSError as error:
            cure = (
                f"give this host an address in the camera's network: ip route get {stream.address}"
            )
            yield Finding(f"packets of {stream.sensor}", f"no way to it ({error.strerror})", cure)
            continue
        yield route.judge_packet_size(stream, way)
        if way.interface is not None and way.speed_mbit is not None:
            rates[way.interface, way.speed_mbit] += stream.bytes_per_s
    for (interface, speed_mbit), rate in rates.items():
        yield route.judge_link_speed(interface, speed_mbit, rate)
