"""Packets dropped, out of order, doubled; whole frames dropped: all identical, or all reported."""

import tempfile
from collections.abc import Mapping
from pathlib import Path

from station.bench.capture_rig import Format, Rig, differing
from station.bench.figures import Row, figure, none_of
from station.capture import Trigger
from station.progress import Progress
from station.recording import LOSSES, events
from station.simulated import Faults
from station.tables import Table

FAULTS: Mapping[str, Faults] = {
    "no fault": Faults(),
    "0.1 % dropped": Faults(packet_loss=0.001, seed=1),
    "1 % dropped": Faults(packet_loss=0.01, seed=2),
    "5 % dropped": Faults(packet_loss=0.05, seed=3),
    "1 % reordered": Faults(packet_reorder=0.01, seed=4),
    "5 % reordered": Faults(packet_reorder=0.05, seed=5),
    "5 % doubled": Faults(packet_duplication=0.05, seed=6),
    "1 % each": Faults(packet_loss=0.01, packet_reorder=0.01, packet_duplication=0.01, seed=7),
}


def bench_packets(
    progress: Progress,
    folder: Path,
    *,
    count: int,
    sends: Format | None = None,
    faults: Mapping[str, Faults] = FAULTS,
) -> Table:
    """Record through a link with each fault, and compare every pixel."""
    rows: list[Row] = []
    for place, (name, fault) in enumerate(faults.items()):
        progress(place / (len(faults) + 1), name)
        rows.append(_packets_row(name, fault, folder, count, sends))
    progress(len(faults) / (len(faults) + 1), "whole frames dropped")
    rows += _lost_frames_rows(folder, count, sends)
    note = f"{count} frames each, {sends or Format()}; a packet sent again may be dropped too."
    return Table("Faults of the link", rows, (note,))


def _packets_row(name: str, faults: Faults, folder: Path, count: int, sends: Format | None) -> Row:
    with (
        tempfile.TemporaryDirectory(dir=folder) as own,
        Rig(Path(own), sends=sends, faults=faults) as rig,
    ):
        report = rig.record(count)
        wrong = differing([rig.path], rig.served) + count - report.recorded
        row = none_of(f"{name}: frames missing or different", wrong)
        return {**row, "spread": f"{report.resent_packets} packets sent again"}


def _lost_frames_rows(folder: Path, count: int, sends: Format | None) -> list[Row]:
    """Drop whole frames, one of them in the middle, two in a row, and the last."""
    lost = frozenset({count // 3, count // 2, count // 2 + 1, count - 1})
    with (
        tempfile.TemporaryDirectory(dir=folder) as own,
        Rig(Path(own), sends=sends, faults=Faults(lost_frames=lost)) as rig,
    ):
        rig.arm(Trigger.LINE1)
        rig.fire(count)
        report = rig.client.finish(expected_frames=count)
        said = sum(event.count for event in events(rig.path) if event.kind in LOSSES)
        wrong = differing([rig.path], rig.served)
    name = f"{len(lost)} whole frames dropped, the last too"
    return [
        figure(f"{name}: lost in the report", report.lost, str(len(lost)), holds=report.lost == 4),
        figure(f"{name}: lost in the file's events", said, str(len(lost)), holds=said == 4),
        figure(f"{name}: called complete", report.complete, "no", holds=not report.complete),
        none_of(f"{name}: others that differ", wrong),
    ]
