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
            tables[one] = [measure(progress) for measure in BENCHES[one]]
    emit(
        {one: [table.as_data() for table in some] for one, some in tables.items()},
        "\n\n".join(table.as_markdown() for some in tables.values() for table in some),
        as_json=as_json,
    )
