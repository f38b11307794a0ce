"""`station bench`: the figures of the README, measured here."""

from typing import Annotated

import typer

from station.bench import BENCHES
from station.cli.output import AsJson, emit, progress_bar
from station.errors import InputUnusable


def bench(
    name: Annotated[
        str | None, typer.Argument(metavar="[NAME]", help=f"One of {', '.join(BENCHES)}; all.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Measure and print the figures of the README."""
    if name is not None and name not in BENCHES:
        raise InputUnusable(f"bench {name!r}; allowed: {', '.join(BENCHES)}")
    tables = {}
    for one in [name] if name is not None else BENCHES:
        with progress_bar(one) as progress:
            tables[one] = BENCHES[one](progress)
    emit(
        {one: table.as_data() for one, table in tables.items()},
        "\n\n".join(table.as_markdown() for table in tables.values()),
        as_json=as_json,
    )
