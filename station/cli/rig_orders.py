"""What `station rig calibrate` is asked for, as the order that boards or a piece take."""

from collections.abc import Sequence
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Self

from calib import Target
from measure import Side
from station.documents import CalibrationDocument, RigDocument
from station.errors import InputUnusable
from station.pipeline import PieceOrder, RigOrder
from station.settings import RigSettings, load_settings

UNNAMED_RIG = "rig"


@dataclass(frozen=True, slots=True)
class PieceOptions:
    """The options that go with a reference piece alone, as they were given.

    Attributes
    ----------
    start
        An earlier rig.json to start from.
    sigma_start_mm, sigma_start_rad
        How surely that is placed and turned.
    laser_off
        Sources of the same placings with the laser off.
    temperature_c
        Of the piece.
    """

    start: Path | None
    sigma_start_mm: float | None
    sigma_start_rad: float | None
    laser_off: Sequence[Path] | None
    temperature_c: float | None

    def refuse_any(self) -> None:
        """Refuse them where boards were shown.

        Raises
        ------
        InputUnusable
            If one was given.
        """
        if any(given is not None for given in astuple(self)):
            raise InputUnusable(
                "--start, --sigma-start-mm, --sigma-start-rad, --laser-off and --temperature go "
                "with --piece; leave them out where boards were shown"
            )


@dataclass(frozen=True, slots=True)
class RigWanted:
    """The rig that is asked for, whatever was shown.

    Attributes
    ----------
    rig
        Its name.
    calibrations
        Of its sensors, in order.
    settings
        What a station's settings say of it, where they do.
    anchor
        The sensor that carries the frame, where it was named at the call.
    side
        Of the train, where it was named at the call.
    """

    rig: str
    calibrations: tuple[CalibrationDocument, ...]
    settings: RigSettings | None
    anchor: str | None
    side: Side | None

    @classmethod
    def read(
        cls,
        calibrations: Sequence[Path],
        rig: str | None,
        config: Path | None,
        *,
        anchor: str | None,
        side: Side | None,
    ) -> Self:
        """Read the calibrations, and the settings where both they and the rig are named.

        Raises
        ------
        InputUnusable
            If a file cannot be used, or the settings have no such rig.
        """
        return cls(
            rig=rig or UNNAMED_RIG,
            calibrations=tuple(CalibrationDocument.read(path) for path in calibrations),
            settings=_settings(config, rig),
            anchor=anchor,
            side=side,
        )

    @property
    def chosen_anchor(self) -> str | None:
        """The anchor by the call, else by the settings."""
        return self.anchor or (None if self.settings is None else self.settings.anchor)

    @property
    def sigma_vibration_mm(self) -> float | None:
        """How far sensors move against each other, by the settings."""
        return None if self.settings is None else self.settings.sigma_vibration_mm

    @property
    def sigma_vibration_rad(self) -> float | None:
        """How far they turn against each other, by the settings."""
        return None if self.settings is None else self.settings.sigma_vibration_rad

    def on_boards(
        self, boards: tuple[Target, ...], *, same_board: bool, board_sigma_mm: float
    ) -> RigOrder:
        """Return the order of the rig from showings of boards."""
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

    def on_piece(self, about: PieceOptions) -> PieceOrder:
        """Return the order of the rig from placings of a reference piece."""
        return PieceOrder(
            rig=self.rig,
            calibrations=self.calibrations,
            start=None if about.start is None else RigDocument.read(about.start),
            sigma_start_mm=about.sigma_start_mm,
            sigma_start_rad=about.sigma_start_rad,
            anchor=self.chosen_anchor,
            side=self.side,
            temperature_c=about.temperature_c,
            sigma_vibration_mm=self.sigma_vibration_mm,
            sigma_vibration_rad=self.sigma_vibration_rad,
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
