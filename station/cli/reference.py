"""`station reference`: the profiles that wear is counted from."""

from pathlib import Path
from typing import Annotated

import typer

from measure import Quantity, ReferenceProfile
from station.cli.output import AsJson, emit
from station.documents import ReferenceDocument
from station.pipeline import is_json, load_reference, read_reference, register_reference

app = typer.Typer(
    help="The profiles that wear is counted from.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@app.command()
def register(
    files: Annotated[
        list[Path],
        typer.Argument(
            metavar="RESULTS...",
            help="results.json, or MiniProf and CSV profiles, of new wheels of one drawing.",
        ),
    ],
    name: Annotated[str, typer.Option(metavar="N", help="What it is called in results.")],
    out: Annotated[Path, typer.Option(metavar="FILE", help="Reference to write, as new.json.")],
    as_json: AsJson = False,
) -> None:
    """Make measured new wheels the reference of those that wear.

    A wheel is turned to its drawing within half a millimetre. Counted from the drawing, that is
    read as wear, or hides it; counted from the wheel as it was new, it is not. Several new wheels
    are averaged. What the reference itself is not known by goes into the uncertainty of every wear
    that is counted from it.
    """
    document = register_reference(files, name)
    document.write(out)
    emit(document.model_dump(mode="json"), _text(document), as_json=as_json)


@app.command()
def show(
    reference: Annotated[str, typer.Argument(metavar="S1002|LMA|FILE")],
    as_json: AsJson = False,
) -> None:
    """Show what the gauges read on a reference, how sure that is, and where it came from."""
    path = Path(reference)
    if path.is_file() and is_json(path):
        document = read_reference(path)
        document.reference()  # Refused where points and readings do not belong together.
        emit(document.model_dump(mode="json"), _text(document), as_json=as_json)
        return
    drawn = load_reference(reference)
    emit(_as_data(drawn), _lines_of(drawn), as_json=as_json)


def _as_data(reference: ReferenceProfile) -> dict[str, object]:
    nominal = {quantity.value: value for quantity, value in reference.nominal.items()}
    return {"name": reference.name, "nominal": nominal}


def _lines_of(reference: ReferenceProfile) -> str:
    nominal = (_figure(quantity, value, "") for quantity, value in reference.nominal.items())
    return "\n".join([f"{reference.name}, as drawn", *nominal])


def _text(document: ReferenceDocument) -> str:
    lines = [f"{document.name}, measured, {document.created:%Y-%m-%d}"]
    for quantity, nominal in document.nominal.items():
        sure = f" \u00b1 {nominal.u95:.3f}"
        spread = "" if nominal.spread is None else f" (wheel to wheel {nominal.spread:.3f})"
        lines.append(_figure(quantity, nominal.value, sure + spread))
    lines += [f"made of {each.wheel} in {each.name}" for each in document.made_of]
    return "\n".join(lines)


def _figure(quantity: Quantity, value_mm: float, after: str) -> str:
    return f"{quantity.value} {value_mm:.3f}{after} mm"
