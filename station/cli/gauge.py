"""`station gauge`: the same readings from a profile file instead of pictures."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer

from measure import gauge_profile
from station.cli.measure import text_of
from station.cli.options import Reference
from station.cli.output import AsJson, emit
from station.documents import MeasurementDocument, wheel_document
from station.errors import NothingMeasurable
from station.pipeline import load_reference, read_profile
from station.software import SOFTWARE


def gauge(
    profiles: Annotated[
        list[Path],
        typer.Argument(metavar="PROFILE...", help="Profiles: MiniProf files or CSV of d,h."),
    ],
    reference: Reference = "S1002",
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="results.json to write.")] = None,
    as_json: AsJson = False,
) -> None:
    """Read the gauges off profile files."""
    new = load_reference(reference)
    document = MeasurementDocument(
        created=datetime.now(UTC),
        software=SOFTWARE,
        calibration=None,
        reference=new.name,
        wheels=tuple(
            wheel_document(gauge_profile(read_profile(path), new), source=path.name, sensor="")
            for path in profiles
        ),
    )
    if out is not None:
        document.write(out)
    emit(document.model_dump(mode="json"), text_of(document), as_json=as_json)
    if not document.measured:
        raise NothingMeasurable(f"none of {len(profiles)} profiles could be measured")
