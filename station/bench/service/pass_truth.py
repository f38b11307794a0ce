"""What became of a pass, held against its files: frames, readings, and what is left lying about."""

import sqlite3
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sqlalchemy import select

from measure import Limits
from station.bench.service.small_sensor import true_calibration
from station.bench.service.station_process import StationProcess
from station.errors import StationError
from station.operations import DataLayout
from station.pipeline import measure_sources
from station.recording import ACTIVE, frames, left_behind, verify
from station.store import Measurement, Pass, PassState, Recording, Store, the, unfinished_jobs

_UNFINISHED = ("PENDING", "ENQUEUED", "DELAYED")
"""States of a workflow that the engine has not done with."""


@dataclass(frozen=True, slots=True)
class PassTruth:
    """How the store's account of a pass compares with its files and with the train."""

    recorded: int
    """Frames in its files."""
    lost: int
    """Triggers that no frame in a file belongs to."""
    unsaid: int
    """Of them, those that the account does not tell; or tells too many of."""
    unsound: int
    """Files that cannot be read whole, and frames that are in them twice."""
    missing: int
    """Frames in the files without a reading."""
    doubled: int
    """Readings of a frame beside the first."""
    differing: int
    """Readings that measuring the files again does not give."""


def truth_of_pass(store: Store, layout: DataLayout, pass_id: str, triggers: int) -> PassTruth:
    """Read the files of a pass, measure them again, and hold its rows against that."""
    with store.look() as session:
        owner = the(session, Pass, pass_id)
        row = session.scalars(select(Recording).where(Recording.pass_id == pass_id)).one()
        kept = session.scalars(select(Measurement).where(Measurement.recording_id == row.id)).all()
    files = [part for _, part in left_behind(layout.root / row.path) if part.exists()]
    ids = [frame.frame_id for part in files for frame in frames(part)]
    said = (row.lost or 0) + (row.refused or 0)
    never_began = owner.state is PassState.FAILED and not ids  # and its reason says so
    fresh = _measured_again(files) if ids else {}
    counted = Counter(each.frame for each in kept)
    return PassTruth(
        recorded=len(ids),
        lost=triggers - len(ids),
        unsaid=0 if never_began else abs(triggers - len(ids) - said),
        unsound=sum(not _sound(part) for part in files) + len(ids) - len(set(ids)),
        missing=len(fresh.keys() - counted.keys()),
        doubled=len(kept) - len(counted),
        differing=sum(each.wheel != fresh.get(each.frame) for each in kept),
    )


def _sound(part: Path) -> bool:
    try:
        return verify(part).ok
    except StationError:
        return False


def _measured_again(files: list[Path]) -> Mapping[int, dict[str, Any]]:
    """Return the wheels in the files by their frames, without profiles, as the store keeps them."""
    found = measure_sources(files, true_calibration(), limits=Limits.default())
    return {
        wheel.frame: wheel.model_dump(mode="json", exclude={"profile"})
        for wheel in found.wheels
        if wheel.frame is not None
    }


def left_over(station: StationProcess, store: Store) -> list[str]:
    """Return what a station at rest has not put away; nothing where all is well."""
    layout, found = station.layout, []
    with store.look() as session:
        found += [f"job {job.id} is {job.state}" for job in unfinished_jobs(session)]
        named = {layout.root / path for path in session.scalars(select(Recording.path))}
    known = {part for path in named for _, part in left_behind(path)}
    recordings = layout.root / "recordings"
    for file in (each for each in recordings.rglob("*") if each.is_file()):
        if file.name.endswith(ACTIVE):
            found.append(f"{file.name} is unfinished")
        elif file not in known:
            found.append(f"{file.relative_to(layout.root)} is in no row")
    found += [f"process {pid} is nobody's" for pid in sorted(station.orphans())]
    found += [f"workflow {name} is {state}" for name, state in _unfinished_workflows(layout)]
    found += [f"{folder.name} is left" for folder in station.folders_of_sockets()[1:]]
    return found + named_memory(station)


def _unfinished_workflows(layout: DataLayout) -> list[tuple[str, str]]:
    marks = ", ".join("?" * len(_UNFINISHED))
    question = f"SELECT workflow_uuid, status FROM workflow_status WHERE status IN ({marks})"  # noqa: S608  question marks
    connection = sqlite3.connect(f"file:{layout.jobs_file}?mode=ro", uri=True)
    try:
        return connection.execute(question, _UNFINISHED).fetchall()
    finally:
        connection.close()


def named_memory(station: StationProcess) -> list[str]:
    """Return shared memory under a name in the system, which would outlive a killed process."""
    found = []
    for pid in station.processes():
        try:
            maps = Path(f"/proc/{pid}/maps").read_text()
        except (FileNotFoundError, ProcessLookupError):
            continue  # it has ended meanwhile
        found += [
            f"process {pid} maps {line.split()[-1]}"
            for line in maps.splitlines()
            if " /dev/shm/" in line
        ]
    return found
