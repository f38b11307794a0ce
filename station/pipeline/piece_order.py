"""What a rig is made of, and what is known of it before a reference piece is shown to it."""

from dataclasses import dataclass

from calib import LaserSensor, RigidTransform
from measure import Side
from station.documents import CalibrationDocument, RigDocument
from station.errors import InputUnusable
from station.pipeline.rig_parts import anchoring_of, ensure_rig


@dataclass(frozen=True, slots=True)
class PieceOrder:
    """What a rig is made of, and what is known of it before a piece is shown.

    Attributes
    ----------
    rig
        Its name.
    calibrations
        Of its sensors, in order.
    start
        An earlier rig of these sensors, from which the search starts; None starts from the
        mountings in their calibrations.
    sigma_start_mm, sigma_start_rad
        How well that is known; None: it fills nothing that the piece leaves open.
    anchor
        The sensor that carries the frame; the first with a mounting where None, else the first.
    side
        Of the train; by the anchor's mounting where None.
    temperature_c
        Of the piece; None counts its warmth as unknown.
    sigma_vibration_mm, sigma_vibration_rad
        As of `measure.Survey`, where they are known.

    Raises
    ------
    InputUnusable
        If the calibrations make no rig, or nothing says where the sensors stand.
    """

    rig: str
    calibrations: tuple[CalibrationDocument, ...]
    start: RigDocument | None = None
    sigma_start_mm: float | None = None
    sigma_start_rad: float | None = None
    anchor: str | None = None
    side: Side | None = None
    temperature_c: float | None = None
    sigma_vibration_mm: float | None = None
    sigma_vibration_rad: float | None = None

    def __post_init__(self) -> None:
        ensure_rig(self.calibrations, self.anchor)
        _ensure_sigma("sigma_start_mm", self.sigma_start_mm)
        _ensure_sigma("sigma_start_rad", self.sigma_start_rad)
        placed = (
            {each.sensor for each in self.calibrations if each.mounting is not None}
            if self.start is None
            else set(self.start.names)
        )
        missing = [each.sensor for each in self.calibrations if each.sensor not in placed]
        if missing:
            raise InputUnusable(
                f"nothing says where {missing[0]} stands; give calibrations with a mounting, or "
                "an earlier rig of these sensors to start from"
            )

    @property
    def sensors(self) -> dict[str, LaserSensor]:
        """The sensors, by name."""
        return {each.sensor: each.laser_sensor() for each in self.calibrations}

    @property
    def anchoring(self) -> CalibrationDocument:
        """The calibration of the anchor."""
        return anchoring_of(self.calibrations, self.anchor)

    def start_poses(self) -> dict[str, RigidTransform]:
        """Return rig_from_camera of each sensor where the search starts."""
        if self.start is not None:
            return {each.name: each.rig_from_camera for each in self.start.to_rig().sensors}
        return {
            each.sensor: each.mounting.rig_from_camera()
            for each in self.calibrations
            if each.mounting is not None
        }


def _ensure_sigma(name: str, sigma: float | None) -> None:
    if sigma is not None and not 0.0 < sigma < float("inf"):
        raise InputUnusable(
            f"{name} is {sigma:g}; allowed: more than 0, or none where nothing is known"
        )
