"""The `[recalibration]` of the settings file: when, from what, within which limits, what then."""

from collections.abc import Mapping
from datetime import time
from pathlib import Path
from typing import Annotated, Any, Literal, Self
from zoneinfo import ZoneInfo

from pydantic import Field, StringConstraints, field_validator, model_validator

from station.settings.section import Section
from station.settings.sensor import SensorId

Day = Literal["mon", "tue", "wed", "thu", "fri", "sat", "sun"]
DAYS: tuple[Day, ...] = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")


class GateSettings(Section):
    """What a new calibration must be, and how far two of a sensor may differ."""

    fewest_poses: int = Field(default=6, ge=3)
    """Poses of the target used, at least: fewer fix the sheet with little to check it by."""
    largest_dots_px: float = Field(default=1.0, gt=0.0)
    """RMS residual of the target's points, px, at most."""
    largest_stripe_px: float = Field(default=1.0, gt=0.0)
    """RMS residual of the stripe's points, px, at most."""
    oldest_pictures_h: float = Field(default=36.0, gt=0.0)
    """Age of the pictures taken, h, at most: older ones do not tell how the sensor is now."""
    drift_mm: float = Field(default=0.1, gt=0.0)
    """How far two calibrations may place a pixel of the working volume from each other, mm."""
    release: float = Field(default=0.7, gt=0.0, le=1.0)
    """Once it has drifted, a sensor is well again below this part of `drift_mm` alone."""
    false_alarm: float = Field(default=0.001, gt=0.0, lt=0.5)
    """Chance of a night that a sensor at rest is found to differ, at most."""
    better: float = Field(default=0.7, gt=0.0, lt=1.0)
    """A calibration is better whose sheet is known to this part of the other's sigma: half of the
    variance, so that it is not changed nightly for the little that a night adds."""
    oldest_calibration_days: float | None = Field(default=None, gt=0.0)
    """Age from which a calibration in force gives way to one that agrees; absent: none does."""
    longest_unchecked_days: float | None = Field(default=None, gt=0.0)
    """Without new pictures for so many days there is an alarm; absent: there is none."""


class PolicySettings(Section):
    """What follows what was found.

    `activate`: the new calibration comes into force; `keep`: the old one stays; `ask`: it stays
    until a person has answered.
    """

    first: Literal["activate", "keep", "ask"] = "ask"
    """No calibration was in force."""
    consistent: Literal["activate", "keep", "ask"] = "keep"
    """They differ by no more than their uncertainties explain."""
    improved: Literal["activate", "keep", "ask"] = "activate"
    """They agree, and the new one knows the sheet better."""
    aged: Literal["activate", "keep", "ask"] = "activate"
    """They agree, and the old one is older than it may be."""
    shifted: Literal["activate", "keep", "ask"] = "keep"
    """They differ, by less than matters."""
    drifted: Literal["activate", "keep", "ask"] = "ask"
    """They differ, by more than matters."""
    doubtful: Literal["keep", "ask"] = "keep"
    """The new one is not to be relied on."""
    confirmations: int = Field(default=2, ge=1, le=10)
    """Recalibrations in a row, agreeing with each other, that must find a drift before `activate`
    follows it by itself; a reference piece that finds it too counts for all of them."""
    measure_again: bool = False
    """Whether, when a drift has been activated, the passes since the last good check are measured
    again; what was measured of them stays."""


class CaptureSettings(Section):
    """A session that the station takes by itself, of a target mounted before a sensor.

    As with every calibration session, a train that comes meanwhile is refused: choose a time at
    which none does, and few seconds.
    """

    target: Annotated[str, StringConstraints(max_length=64)]
    """For example dots:7x8:12."""
    pictures: int = Field(default=12, ge=1, le=200)
    """Poses; each is taken with the sensor's `calibration_exposures`."""
    pause_s: float = Field(default=5.0, ge=0.0, le=60.0)
    """Time for the mount to bring the target into its next pose, s: one pose fixes no sheet."""

    @field_validator("target")
    @classmethod
    def _target_parses(cls, text: str) -> str:
        # Imported here: every process of the station reads its settings, few calculate.
        from calib import CalibError, Target  # noqa: PLC0415

        try:
            return str(Target.parse(text))
        except CalibError as error:
            raise ValueError(str(error)) from error


class PieceSettings(Section):
    """The reference piece of a sensor."""

    certificate: Path
    """Its certificate, a treadline-piece file."""
    sessions: str = Field(default="piece-", min_length=1, max_length=32)
    """Calibration sessions whose names begin so show the piece, not a target."""
    holder_kept: bool = False
    """Whether its holder stays where it is: it must then be seen where the first check saw it."""
    limit_mm: float | None = Field(default=None, gt=0.0)
    """How far a dimension may be off, mm; absent: what its uncertainties allow."""
    required: bool = False
    """Whether nothing is activated by itself unless the piece comes out right."""


class SensorRecalibrationSettings(Section):
    """What is particular of one sensor."""

    method: Literal["joint", "deviation", "preplanar"] = "joint"
    """How its light plane is solved."""
    camera: Literal["in_force", "solve"] = "in_force"
    """Whether what is known of the camera goes into the new calibration, or the new pictures alone
    tell of it: after its lens or focus was changed they must."""
    capture: CaptureSettings | None = None
    """A session to take where there is none that is new; absent: somebody records one."""
    piece: PieceSettings | None = None
    """Its reference piece; absent: it has none."""


class RecalibrationSettings(Section):
    """Recalibration of the sensors: nightly, and on call."""

    at: time | None = None
    """Time of the day, as 02:30:00; absent: on call alone."""
    days: tuple[Day, ...] = Field(default=DAYS, min_length=1)
    """The days on which it runs."""
    zone: str = "UTC"
    """The station's time zone, as Europe/Berlin: what `at` and `days` are counted in."""
    patience_h: float = Field(default=3.0, ge=0.0, le=24.0)
    """How long it waits for passes to end before it gives up, h."""
    gates: GateSettings = GateSettings()
    """What a new calibration must be."""
    policy: PolicySettings = PolicySettings()
    """What follows."""
    sensors: Mapping[SensorId, SensorRecalibrationSettings] = Field(default_factory=dict)
    """What is particular of single sensors."""

    @field_validator("at")
    @classmethod
    def _at_is_local(cls, at: time | None) -> time | None:
        if at is not None and at.tzinfo is not None:
            raise ValueError("give the time of the day without a zone, as 02:30:00, and set `zone`")
        return at

    @field_validator("zone")
    @classmethod
    def _zone_is_known(cls, zone: str) -> str:
        try:
            ZoneInfo(zone)
        except (KeyError, ValueError, OSError) as error:
            raise ValueError(
                f"zone {zone!r}: this host knows no such one; give one as Europe/Berlin"
            ) from error
        return zone

    @model_validator(mode="after")
    def _days_differ(self) -> Self:
        if len(set(self.days)) < len(self.days):
            raise ValueError("a day is given twice; give each once")
        return self

    def of(self, sensor: str) -> SensorRecalibrationSettings:
        """Return what is particular of a sensor: nothing, where it is not named."""
        return self.sensors.get(sensor, SensorRecalibrationSettings())

    def beside(self, folder: Path) -> Self:
        """Return the same with relative files counted from a folder."""
        return self.model_copy(
            update={"sensors": {name: _beside(each, folder) for name, each in self.sensors.items()}}
        )


def _beside(settings: SensorRecalibrationSettings, folder: Path) -> SensorRecalibrationSettings:
    if settings.piece is None:
        return settings
    certificate: dict[str, Any] = {"certificate": (folder / settings.piece.certificate).resolve()}
    return settings.model_copy(update={"piece": settings.piece.model_copy(update=certificate)})
