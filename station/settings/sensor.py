"""The settings of one sensor: its camera, its exposures, its place beside the track."""

from typing import Annotated, Literal, Self

from pydantic import Field, StringConstraints, model_validator

from station.settings.section import Section

SensorId = Annotated[str, StringConstraints(pattern=r"^[a-z0-9][a-z0-9_-]{0,31}$")]


class MountingSettings(Section):
    """How a sensor sits beside the track: the survey of its installation."""

    rotation_vector: tuple[float, float, float]
    """Rotation vector of rig_from_camera, rad."""
    translation_mm: tuple[float, float, float]
    """Translation of rig_from_camera: the camera's place in the rig frame, mm."""
    wheel_radius_mm: float = Field(default=420.0, gt=100.0, lt=1000.0)
    """Nominal radius of the wheels at the tape circle, mm."""
    sigma_radius_mm: float | None = Field(default=None, gt=0.0)
    """How far wheels differ from it, one sigma, mm; this and the next, where absent: as
    `measure.Mounting` takes them."""
    sigma_axle_x_mm: float | None = Field(default=None, gt=0.0)
    """How far from the sheet axles stand when a picture is taken, mm."""
    sigma_height_mm: float | None = Field(default=None, gt=0.0)
    """How far the tread is from the rail's nominal top: survey, load, bounce, mm."""
    sigma_axle_direction_rad: float | None = Field(default=None, gt=0.0)
    """How far axles are from rig y: survey, cant, yaw of the bogie, rad."""


class RegionSettings(Section):
    """The part of the sensor chip that is read out; what is absent stays as large as it can be."""

    offset_x_px: int = Field(default=0, ge=0)
    """Columns left out on the left, px."""
    offset_y_px: int = Field(default=0, ge=0)
    """Rows left out at the top, px."""
    width_px: int | None = Field(default=None, gt=0)
    """Columns read out, px."""
    height_px: int | None = Field(default=None, gt=0)
    """Rows read out, px."""
    binning_x: int | None = Field(default=None, ge=1)
    """Columns of the chip that make one of the picture; offsets and sizes count after it."""
    binning_y: int | None = Field(default=None, ge=1)
    """Rows of the chip that make one of the picture."""


class ExposureSettings(Section):
    """One frame of an exposure sequence."""

    exposure_us: float = Field(gt=0.0)
    """Exposure time, us."""
    gain_db: float | None = None
    """Gain, dB; the sensor's where absent."""
    laser: bool = True
    """Whether the laser shines; switching it needs `laser_output`."""


def _negative(value: object) -> bool:
    # What is no number is refused by the mounting itself.
    return isinstance(value, int | float) and value < 0.0


class SensorSettings(Section):
    """One sensor: a camera, its laser, and where it stands."""

    id: SensorId
    """Name of the sensor: lower-case letters, digits, - and _."""
    address: str
    """IP address of the camera; Fake_1 is the one that Aravis brings for trials."""
    side: Literal["left", "right"] = "left"
    """The side of the train whose wheels it sees; absent: that of its mounting, else left.

    As rig y points to the field on both sides, sensors that mirror each other across the track
    stand at opposite x of their rigs: at x below 0 it is taken for the right one.
    """
    trigger: Literal["free", "software", "Line1"] = "Line1"
    """What starts an exposure in a pass."""
    exposure_us: float | None = Field(default=None, gt=0.0)
    """Exposure time, µs; the camera's own where absent."""
    gain_db: float | None = None
    """Gain, dB; the camera's own where absent."""
    black_level: float | None = Field(default=None, ge=0.0)
    """Level of a dark pixel, in the camera's unit; its own where absent."""
    region: RegionSettings = RegionSettings()
    """The part of the chip that is read out; a calibration holds for one region alone."""
    trigger_activation: Literal["RisingEdge", "FallingEdge", "AnyEdge"] | None = None
    """Which edge of the line triggers; the rising one where absent."""
    trigger_delay_us: float | None = Field(default=None, ge=0.0)
    """Time from the trigger to the exposure, us."""
    trigger_debounce_us: float | None = Field(default=None, ge=0.0)
    """Pulses of line 1 shorter than this are none, us."""
    outputs: dict[str, bool] = Field(default_factory=dict)
    """Levels of the user outputs, as UserOutput0 = true."""
    laser_output: str | None = None
    """The user output that switches the laser, as UserOutput0; absent where none does."""
    calibration_exposures: tuple[ExposureSettings, ...] = Field(default=(), max_length=16)
    """Frames taken of each pose in a calibration session: dots and stripe want different ones."""
    features: dict[str, bool | int | float | str] = Field(default_factory=dict)
    """Other GenICam features of the camera, by name; they are set first, in this order."""
    frame_rate_hz: float = Field(default=53.0, gt=0.0)
    """Frames a second in free run."""
    packet_size: int = Field(default=9000, ge=576, le=16384)
    """GVSP packet size, bytes; the path must carry it."""
    packet_delay_ns: int | None = Field(default=None, ge=0)
    """Pause between packets, ns; several cameras on one link need it."""
    ring_slots: int = Field(default=128, ge=4, le=1024)
    """Frames the memory between camera and disk holds: 128 bridge 2.4 s of a slow disk at 53 Hz."""
    mounting: MountingSettings | None = None
    """Where the sensor stands; wheel sections need it."""

    @model_validator(mode="before")
    @classmethod
    def _side_of_mounting(cls, given: object) -> object:
        if not isinstance(given, dict) or given.get("side") is not None:
            return given
        mounting = given.get("mounting")
        survey = mounting.model_dump() if isinstance(mounting, MountingSettings) else mounting
        place = survey.get("translation_mm") if isinstance(survey, dict) else None
        mirrored = isinstance(place, list | tuple) and len(place) == 3 and _negative(place[0])
        return {**given, "side": "right" if mirrored else "left"}

    @model_validator(mode="after")
    def _laser_can_be_switched(self) -> Self:
        dark = any(not step.laser for step in self.calibration_exposures)
        if dark and self.laser_output is None:
            raise ValueError(
                "calibration_exposures switch the laser off but nothing switches it; "
                'give laser_output, as "UserOutput0"'
            )
        if self.laser_output in self.outputs:
            raise ValueError(
                f"outputs set {self.laser_output}, which is the laser's; take it out of outputs"
            )
        return self
