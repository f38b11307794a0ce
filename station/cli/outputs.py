"""What `measure`, `gauge` and `results` write: tables, points, MiniProf files and drawings."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from measure import Limits, ReferenceProfile, Side
from station.documents import CalibrationDocument, MeasurementDocument
from station.errors import InputUnusable
from station.exports import (
    check_table_name,
    check_target,
    table_writer,
    write_miniprof,
    write_points,
)
from station.limits import limits_of
from station.settings import TrackSettings, load_settings

Out = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Readings: results.json, .csv or .parquet, a row a wheel."),
]
Profiles = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Points of the profiles: .csv or .parquet, a row a point."),
]
Miniprof = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE|DIR",
        help="MiniProf files: a folder, or a file that is numbered where there are several wheels.",
    ),
]
Plot = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE|DIR",
        help="Profiles over the reference as SVG: one below the other in a file, a file each in "
        "a folder.",
    ),
]
Config = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="station.toml whose [limits] raise the alarms, with sides of sensors and [track].",
    ),
]


@dataclass(frozen=True, slots=True)
class Outputs:
    """Where the results go; what is None is not written.

    Raises
    ------
    InputUnusable
        If a name stands for no kind of file, or its folder is not there: before any measuring.
    """

    out: Path | None
    profiles: Path | None
    miniprof: Path | None
    plot: Path | None

    def __post_init__(self) -> None:
        if self.out is not None:
            table_writer(self.out)
        if self.profiles is not None:
            check_table_name(self.profiles, "--profiles")
        for option, path in (
            ("--out", self.out),
            ("--profiles", self.profiles),
            ("--miniprof", self.miniprof),
            ("--plot", self.plot),
        ):
            if path is not None:
                check_target(path, option)

    def write(
        self, document: MeasurementDocument, reference: Callable[[], ReferenceProfile]
    ) -> Sequence[Path]:
        """Write everything that was asked for, and return what was written."""
        written: list[Path] = []
        if self.out is not None:
            if self.out.suffix == ".json":
                document.write(self.out)
            else:
                table_writer(self.out)(self.out, document, document.wheels)
            written.append(self.out)
        if self.profiles is not None:
            write_points(self.profiles, document.wheels)
            written.append(self.profiles)
        if self.miniprof is not None:
            written += write_miniprof(self.miniprof, document)
        if self.plot is not None:
            # Drawing is imported where it is asked for: every command passes through here.
            from station.plots import write_plots  # noqa: PLC0415  see the line above

            written += write_plots(self.plot, document.wheels, reference())
        return written


def limits_in_force(config: Path | None) -> Limits:
    """Return the limits of a station's settings, or those of practice."""
    return Limits.default() if config is None else limits_of(load_settings(config).limits)


def sides_known(
    config: Path | None, calibrations: Sequence[CalibrationDocument]
) -> dict[str, Side]:
    """Return the side of each sensor: by a station's settings, or by its name, left or right."""
    if config is not None:
        return {sensor.id: Side(sensor.side) for sensor in load_settings(config).sensors}
    names = {calibration.sensor for calibration in calibrations}
    return {side.value: side for side in Side if side.value in names}


def skews_known(config: Path | None) -> dict[str, float]:
    """Return how far frames of one shot may be apart, us, of the rigs in a station's settings."""
    return {} if config is None else {rig.id: rig.max_skew_us for rig in load_settings(config).rigs}


def track_known(config: Path | None) -> TrackSettings | None:
    """Return how left and right stand to each other by a station's settings."""
    return None if config is None else load_settings(config).track


def refuse_same_file(outputs: Outputs, inputs: Sequence[Path]) -> None:
    """Refuse to write over what is read.

    Raises
    ------
    InputUnusable
        If a file is input and output at once.
    """
    given = {path.resolve() for path in inputs}
    for path in (outputs.out, outputs.profiles, outputs.miniprof, outputs.plot):
        if path is not None and path.resolve() in given and not path.is_dir():
            raise InputUnusable(f"{path} is read and cannot be written; give another name")
