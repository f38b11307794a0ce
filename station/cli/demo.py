"""`station demo`: the whole chain on simulated cameras, beside the truth."""

import tempfile
from pathlib import Path
from typing import Annotated

import typer

from station.cli.output import AsJson, emit, progress_bar
from station.demo import DemoResult, as_data, as_text, run_demo
from station.errors import InputUnusable, NothingMeasurable


def demo(
    out: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder to keep recordings, calibrations, results in."),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Which demo: same seed, same truth.")] = 1,
    as_json: AsJson = False,
) -> None:
    """Run the whole chain on simulated GigE cameras and print measured beside true values."""
    if out is None:
        with tempfile.TemporaryDirectory(prefix="treadline-demo-") as folder:
            result = _run(Path(folder), seed)
    else:
        result = _run(_empty_folder(out), seed)
    emit(as_data(result), as_text(result), as_json=as_json)
    if not result.good:
        raise NothingMeasurable("a frame was lost or a wheel not measured; the tables say which")


def _run(folder: Path, seed: int) -> DemoResult:
    with progress_bar("demo") as progress:
        return run_demo(folder.resolve(), seed, progress)


def _empty_folder(out: Path) -> Path:
    try:
        out.mkdir(parents=True, exist_ok=True)
        if any(out.iterdir()):
            raise InputUnusable(f"{out}: not empty; give a new folder, so that nothing is mixed")
    except OSError as error:
        raise InputUnusable(f"{out}: cannot be made ({error.strerror}); give a folder") from error
    return out
