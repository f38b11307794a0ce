"""`station rig calibrate`: from showings of a target, or of a piece, to rig.json."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from calib import Target
from measure import Side
from station.cli.evaluate_piece import LaserOff, Temperature
from station.cli.options import OptionalTargets
from station.cli.output import AsJson, emit, progress_bar
from station.cli.outputs import Config
from station.cli.rig_text import text_of_rig
from station.documents import BOARD_SIGMA_MM, CalibrationDocument, PieceDocument, RigDocument
from station.errors import InputUnusable, NothingMeasurable
from station.pipeline import (
    PieceOrder,
    RigOrder,
    calibrate_rig_on_piece,
    calibrate_rig_sources,
)
from station.settings import RigSettings, load_settings

UNNAMED_RIG = "rig"


def calibrate(
    sources: Annotated[
        list[Path],
        typer.Argument(
            metavar="SOURCE...",
            help="One of each sensor: its recording, folder of pictures, or points.csv.",
        ),
    ],
    calibration: Annotated[
        list[Path], typer.Option(metavar="FILE", help="calibration.json, once for each sensor.")
    ],
    out: Annotated[Path, typer.Option(metavar="FILE", help="rig.json to write.")],
    target: OptionalTargets = None,
    piece: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="piece.json: a reference piece was shown, no board."),
    ] = None,
    rig: Annotated[
        str | None, typer.Option(metavar="ID", help="Name of the rig, as in station.toml.")
    ] = None,
    anchor: Annotated[
        str | None,
        typer.Option(
            metavar="ID", help="Sensor that carries the frame; else the first with a mounting."
        ),
    ] = None,
    side: Annotated[
        Side | None, typer.Option(help="Side of the train; by the anchor's mounting without.")
    ] = None,
    same_board: Annotated[
        bool, typer.Option("--same-board", help="All sensors see one and the same board.")
    ] = False,
    board_sigma_mm: Annotated[
        float,
        typer.Option(metavar="MM", min=0.0, max=1.0, help="How far dots are from their places."),
    ] = BOARD_SIGMA_MM,
    start: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Earlier rig.json to start from, with --piece."),
    ] = None,
    sigma_start_mm: Annotated[
        float | None,
        typer.Option(metavar="MM", min=0.0, help="How surely the start is placed, with --piece."),
    ] = None,
    sigma_start_rad: Annotated[
        float | None,
        typer.Option(metavar="RAD", min=0.0, help="How surely it is turned, with --piece."),
    ] = None,
    laser_off: LaserOff = None,
    temperature: Temperature = None,
    config: Config = None,
    as_json: AsJson = False,
) -> None:
    """Solve where the sensors of a rig stand, from showings of a rigid target to all of them.

    Pictures of one showing are told by their times, else by alike names, else by their order;
    folders and points.csv are given in the order of the calibrations.
    """
    wanted = _Wanted(
        rig=rig or UNNAMED_RIG,
        calibrations=tuple(CalibrationDocument.read(path) for path in calibration),
        settings=_settings(config, rig),
        anchor=anchor,
        side=side,
    )
    if (piece is None) == (not target):
        raise InputUnusable("give either --target of the boards, or --piece, as it was shown")
    with progress_bar("calibrate") as progress:
        if piece is None:
            boards = tuple(Target.parse(text) for text in target or ())
            _refuse_of_piece(start, sigma_start_mm, sigma_start_rad, laser_off, temperature)
            document = calibrate_rig_sources(
                sources,
                wanted.on_boards(boards, same_board=same_board, board_sigma_mm=board_sigma_mm),
                progress=progress,
            )
        else:
            earlier = None if start is None else RigDocument.read(start)
            document = calibrate_rig_on_piece(
                sources,
                wanted.on_piece(earlier, sigma_start_mm, sigma_start_rad, temperature),
                PieceDocument.read(piece).piece(),
                laser_off=laser_off or (),
                progress=progress,
            )
    document.write(out)
    text = f"{text_of_rig(document)}\nwritten to {out}"
    emit(document.model_dump(mode="json"), text, as_json=as_json)
    failed = [name for name, gate in document.quality.items() if not gate.passed]
    if failed:
        raise NothingMeasurable(
            f"{out} was written but fails the gates {', '.join(failed)}; look at the showings "
            "named in it, take more with other turns, then calibrate again"
        )


@dataclass(frozen=True, slots=True)
class _Wanted:
    """What is asked for, whatever was shown."""

    rig: str
    calibrations: tuple[CalibrationDocument, ...]
    settings: RigSettings | None
    anchor: str | None
    side: Side | None

    @property
    def chosen_anchor(self) -> str | None:
        return self.anchor or (None if self.settings is None else self.settings.anchor)

    @property
    def sigma_vibration_mm(self) -> float | None:
        return None if self.settings is None else self.settings.sigma_vibration_mm

    @property
    def sigma_vibration_rad(self) -> float | None:
        return None if self.settings is None else self.settings.sigma_vibration_rad

    def on_boards(
        self, boards: tuple[Target, ...], *, same_board: bool, board_sigma_mm: float
    ) -> RigOrder:
        return RigOrder(
            rig=self.rig,
            calibrations=self.calibrations,
            boards=boards,
            same_board=same_board,
            board_sigma_mm=board_sigma_mm,
            anchor=self.chosen_anchor,
            side=self.side,
            sigma_vibration_mm=self.sigma_vibration_mm,
            sigma_vibration_rad=self.sigma_vibration_rad,
        )

    def on_piece(
        self,
        start: RigDocument | None,
        sigma_start_mm: float | None,
        sigma_start_rad: float | None,
        temperature_c: float | None,
    ) -> PieceOrder:
        return PieceOrder(
            rig=self.rig,
            calibrations=self.calibrations,
            start=start,
            sigma_start_mm=sigma_start_mm,
            sigma_start_rad=sigma_start_rad,
            anchor=self.chosen_anchor,
            side=self.side,
            temperature_c=temperature_c,
            sigma_vibration_mm=self.sigma_vibration_mm,
            sigma_vibration_rad=self.sigma_vibration_rad,
        )


def _refuse_of_piece(*given: object) -> None:
    if any(each is not None for each in given):
        raise InputUnusable(
            "--start, --sigma-start-mm, --sigma-start-rad, --laser-off and --temperature go with "
            "--piece; leave them out where boards were shown"
        )


def _settings(config: Path | None, rig: str | None) -> RigSettings | None:
    if config is None or rig is None:
        return None
    settings = load_settings(config)
    found = settings.rig(rig)
    if found is None:
        known = ", ".join(each.id for each in settings.rigs) or "none"
        raise InputUnusable(f"--rig {rig}: {config} has {known}; give one of those")
    return found
