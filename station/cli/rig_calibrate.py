"""`station rig calibrate`: from showings of a target, or of a piece, to rig.json."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from calib import Target
from measure import Side
from station.cli.evaluate_piece import LaserOff, Temperature
from station.cli.options import OptionalTargets
from station.cli.output import AsJson, emit, progress_bar
from station.cli.outputs import Config
from station.cli.rig_orders import PieceOptions, RigWanted
from station.cli.rig_text import text_of_rig
from station.documents import BOARD_SIGMA_MM, PieceDocument, RigDocument
from station.errors import InputUnusable, NothingMeasurable
from station.pipeline import calibrate_rig_on_piece, calibrate_rig_sources
from station.progress import Progress

SourceOfEach = Annotated[
    list[Path],
    typer.Argument(
        metavar="SOURCE...",
        help="One of each sensor: its recording, folder of pictures, or points.csv.",
    ),
]
CalibrationOfEach = Annotated[
    list[Path], typer.Option(metavar="FILE", help="calibration.json, once for each sensor.")
]
RigOut = Annotated[Path, typer.Option(metavar="FILE", help="rig.json to write.")]
PieceShown = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="piece.json: a reference piece was shown, no board."),
]
RigName = Annotated[
    str | None, typer.Option(metavar="ID", help="Name of the rig, as in station.toml.")
]
Anchor = Annotated[
    str | None,
    typer.Option(
        metavar="ID", help="Sensor that carries the frame; else the first with a mounting."
    ),
]
SideOfTrain = Annotated[
    Side | None, typer.Option(help="Side of the train; by the anchor's mounting without.")
]
SameBoard = Annotated[
    bool, typer.Option("--same-board", help="All sensors see one and the same board.")
]
BoardSigma = Annotated[
    float,
    typer.Option(metavar="MM", min=0.0, max=1.0, help="How far dots are from their places."),
]
EarlierRig = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Earlier rig.json to start from, with --piece."),
]
SigmaStartMm = Annotated[
    float | None,
    typer.Option(metavar="MM", min=0.0, help="How surely the start is placed, with --piece."),
]
SigmaStartRad = Annotated[
    float | None,
    typer.Option(metavar="RAD", min=0.0, help="How surely it is turned, with --piece."),
]


def calibrate(
    sources: SourceOfEach,
    calibration: CalibrationOfEach,
    out: RigOut,
    target: OptionalTargets = None,
    piece: PieceShown = None,
    rig: RigName = None,
    anchor: Anchor = None,
    side: SideOfTrain = None,
    same_board: SameBoard = False,
    board_sigma_mm: BoardSigma = BOARD_SIGMA_MM,
    start: EarlierRig = None,
    sigma_start_mm: SigmaStartMm = None,
    sigma_start_rad: SigmaStartRad = None,
    laser_off: LaserOff = None,
    temperature: Temperature = None,
    config: Config = None,
    as_json: AsJson = False,
) -> None:
    """Solve where the sensors of a rig stand, from showings of a rigid target to all of them.

    Pictures of one showing are told by their times, else by alike names, else by their order;
    folders and points.csv are given in the order of the calibrations.
    """
    wanted = RigWanted.read(calibration, rig, config, anchor=anchor, side=side)
    about_piece = PieceOptions(start, sigma_start_mm, sigma_start_rad, laser_off, temperature)
    if (piece is None) == (not target):
        raise InputUnusable("give either --target of the boards, or --piece, as it was shown")
    with progress_bar("calibrate") as progress:
        if piece is None:
            boards = tuple(Target.parse(text) for text in target or ())
            about_piece.refuse_any()
            order = wanted.on_boards(boards, same_board=same_board, board_sigma_mm=board_sigma_mm)
            document = calibrate_rig_sources(sources, order, progress=progress).document
        else:
            document = _from_piece(sources, wanted, about_piece, piece, progress)
    _answer(document, out, as_json=as_json)


def _from_piece(
    sources: Sequence[Path], wanted: RigWanted, about: PieceOptions, piece: Path, progress: Progress
) -> RigDocument:
    return calibrate_rig_on_piece(
        sources,
        wanted.on_piece(about),
        PieceDocument.read(piece).piece(),
        laser_off=about.laser_off or (),
        progress=progress,
    )


def _answer(document: RigDocument, out: Path, *, as_json: bool) -> None:
    document.write(out)
    text = f"{text_of_rig(document)}\nwritten to {out}"
    emit(document.model_dump(mode="json"), text, as_json=as_json)
    failed = [name for name, gate in document.quality.items() if not gate.passed]
    if failed:
        raise NothingMeasurable(
            f"{out} was written but fails the gates {', '.join(failed)}; look at the showings "
            "named in it, take more with other turns, then calibrate again"
        )
