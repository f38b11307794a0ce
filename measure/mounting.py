"""Where a rig stands beside the track, and what is known of the wheels that pass."""

from dataclasses import dataclass, fields

from calib import RigidTransform


@dataclass(frozen=True, slots=True, kw_only=True)
class Survey:
    """What is known of the wheels that pass a rig, and how well.

    The axle runs along rig y, at the height of the wheel's radius over the rail; its place along
    the rail at the moment of a picture is solved from the picture.

    Attributes
    ----------
    wheel_radius_mm
        Nominal radius at the tape circle.
    sigma_radius_mm
        How far wheels differ from it.
    sigma_axle_x_mm
        How far from the sheet axles stand when a picture is taken.
    sigma_height_mm
        How far the tread at the tape circle is from the rail's nominal top: survey, load, bounce.
    sigma_axle_direction_rad
        How far the axle is from rig y: survey, cant, yaw of the bogie. It tilts the section.
    sigma_vibration_mm
        How far sensors of one rig move against each other, along each axis of a section, between
        their exposures.
    sigma_vibration_rad
        How far they turn against each other in the section.

    Raises
    ------
    ValueError
        If a length or an angle is not positive.
    """

    wheel_radius_mm: float = 420.0
    sigma_radius_mm: float = 10.0
    sigma_axle_x_mm: float = 60.0
    sigma_height_mm: float = 1.0
    sigma_axle_direction_rad: float = 5e-4
    sigma_vibration_mm: float = 0.3
    sigma_vibration_rad: float = 2e-4

    def __post_init__(self) -> None:
        for each in fields(Survey):
            if not 0.0 < getattr(self, each.name) < float("inf"):
                raise ValueError(f"{each.name} must be positive, got {getattr(self, each.name)!r}")


@dataclass(frozen=True, slots=True, eq=False)
class Mounting(Survey):
    """The survey of one sensor's installation: what turns points in the camera into a section.

    Attributes
    ----------
    rig_from_camera
        The camera's place in the rig frame.

    Raises
    ------
    ValueError
        As `Survey`.
    """

    rig_from_camera: RigidTransform
