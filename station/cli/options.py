"""Options that several commands share."""

from pathlib import Path
from typing import Annotated

import typer

Sources = Annotated[
    list[Path],
    typer.Argument(
        metavar="SOURCE...", help="Recordings (.mcap), pictures or folders of pictures."
    ),
]
TargetText = Annotated[
    str,
    typer.Option(
        "--target",
        metavar="TARGET",
        help="dots:ROWSxCOLS:PITCH_MM[:dark][:d=DIAMETER_MM] or chessboard:ROWSxCOLS:PITCH_MM",
    ),
]
CalibrationPath = Annotated[
    Path, typer.Option("--calibration", metavar="FILE", help="calibration.json of the sensor.")
]
OptionalTargets = Annotated[
    list[str] | None,
    typer.Option(
        "--target",
        metavar="TARGET",
        help="The board, as dots:ROWSxCOLS:PITCH_MM; once for all sensors, or once for each.",
    ),
]
OptionalCalibrations = Annotated[
    list[Path] | None,
    typer.Option(
        "--calibration",
        metavar="FILE",
        help="calibration.json of the sensor; once for each sensor of a pass.",
    ),
]
RigPaths = Annotated[
    list[Path] | None,
    typer.Option(
        "--rig",
        metavar="FILE",
        help="rig.json of sensors that look at the same wheel; once for each rig of a pass.",
    ),
]
SensorOption = Annotated[
    str | None, typer.Option("--sensor", metavar="ID", help="Name of the sensor.")
]
Reference = Annotated[
    str,
    typer.Option(
        "--reference",
        metavar="S1002|LMA|FILE",
        help="What wear is counted from: a profile file, or one of `station reference register`.",
    ),
]
