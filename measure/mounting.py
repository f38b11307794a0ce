"""Where a sensor stands beside the track, and what is known of the wheels that pass."""

from dataclasses import dataclass

from calib import RigidTransform


@dataclass(frozen=True, slots=True, eq=False)
class Mounting:
    """The survey of an installation: what turns points in the camera into a wheel's section.

    The axle runs along rig y, at the height of the wheel's radius over the rail; its place along
    the rail at the moment of a picture is solved from the picture.

    Attributes
    ----------
    rig_from_camera
        The camera's place in the rig frame.
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

    Raises
    ------
    ValueError
        If the radius or a sigma is not positive.
    """

    rig_from_camera: RigidTransform
    wheel_radius_mm: float = 420.0
    sigma_radius_mm: float = 10.0
    sigma_axle_x_mm: float = 60.0
    sigma_height_mm: float = 1.0
    sigma_axle_direction_rad: float = 5e-4

    def __post_init__(self) -> None:
        for name in (
            "wheel_radius_mm",
            "sigma_radius_mm",
            "sigma_axle_x_mm",
            "sigma_height_mm",
            "sigma_axle_direction_rad",
        ):
            if not 0.0 < getattr(self, name) < float("inf"):
                raise ValueError(f"{name} must be positive, got {getattr(self, name)!r}")
