"""What every command prints: one JSON document or text on stdout, progress on stderr."""

import json
import sys
from collections.abc import Generator
from contextlib import contextmanager
from typing import Annotated, Any

import typer

from station.progress import Progress, silent

AsJson = Annotated[bool, typer.Option("--json", help="One JSON document on stdout.")]


def emit(document: Any, text: str, *, as_json: bool) -> None:
    """Print `document` as JSON, or `text` for people."""
    typer.echo(json.dumps(document, indent=2, allow_nan=False) if as_json else text)


@contextmanager
def progress_bar(title: str) -> Generator[Progress]:
    """Show a progress bar on stderr while the block runs, where stderr is a terminal."""
    if not sys.stderr.isatty():
        yield silent
        return
    from rich.console import Console  # noqa: PLC0415  rich costs 0.1 s: only where it is seen
    from rich.progress import BarColumn, TextColumn, TimeElapsedColumn  # noqa: PLC0415
    from rich.progress import Progress as Bar  # noqa: PLC0415

    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Bar(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(title, total=1.0)
        yield lambda fraction, what: bar.update(
            task, completed=fraction, description=f"{title}: {what}"
        )
