"""`station doctor`: what on this host would lose frames or data, and the cure."""

from pathlib import Path
from typing import Annotated

import typer

from station.cli.output import AsJson, emit, progress_bar
from station.doctor import Finding, Patient, examine
from station.errors import NothingMeasurable
from station.settings import load_settings

_DEFAULT_CONFIG = Path("station.toml")


def doctor(
    config: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Settings of the station (TOML); else station.toml where there is one.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Say what on this host would lose frames or data, and what to type; exit 1 where anything.

    Run it as the user of the service: root is granted what a service may not be.
    It writes 256 MB to the disk of the recordings, so not while a train passes.
    """
    patient = _patient(config)
    with progress_bar("doctor") as progress:
        findings = examine(patient, progress)
    bad = [finding.name for finding in findings if not finding.fine]
    document = {"fine": not bad, "findings": [finding.to_json() for finding in findings]}
    emit(document, "\n".join(_lines(finding) for finding in findings), as_json=as_json)
    if bad:
        raise NothingMeasurable(
            f"{len(bad)} of {len(findings)} would lose frames or data: {', '.join(bad)}"
        )


def _patient(config: Path | None) -> Patient:
    if config is None and not _DEFAULT_CONFIG.exists():
        return Patient(Path.cwd())
    return Patient.of(load_settings(config or _DEFAULT_CONFIG))


def _lines(finding: Finding) -> str:
    if finding.cure is None:
        return f"fine  {finding.name}: {finding.seen}"
    return f"LOSES {finding.name}: {finding.seen}\n      {finding.cure}"
