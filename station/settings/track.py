"""The `[track]` of the settings file: how the rigs of both sides stand to each other."""

from typing import TYPE_CHECKING, Self

from pydantic import Field, model_validator

from station.settings.rig import MAX_SKEW_US
from station.settings.section import Section

if TYPE_CHECKING:
    from measure import TrackFrame

_Vector = tuple[float, float, float]


class TrackSettings(Section):
    """How the left rig stands beside the right one: what tells flange back from flange back.

    Either `distance_mm`, where the rig frames face each other, or the whole pose of the left rig
    in the right one's frame. A sensor that is in no rig stands in its rig frame by its mounting.
    """

    distance_mm: float | None = Field(default=None, gt=500.0, lt=2500.0)
    """From one rig's origin to the other's: tape circle to tape circle, along the axle, mm."""
    rotation_vector: _Vector | None = None
    """Rotation vector of right_from_left, rad: half a turn about the vertical, or nearly."""
    translation_mm: _Vector | None = None
    """Translation of right_from_left: the left rig's origin in the right one's frame, mm."""
    sigma_distance_mm: float = Field(gt=0.0, allow_inf_nan=False)
    """How far the distance may be off, one sigma, mm; of a whole pose, along each axis."""
    sigma_turn_rad: float = Field(default=5e-4, gt=0.0, allow_inf_nan=False)
    """How far the rigs may be turned against each other about each axis, one sigma, rad; at this
    value, a careful survey's, it is most of u95: 0.4 mm where a sheet meets the flange."""
    max_skew_us: float = Field(default=MAX_SKEW_US, gt=0.0, le=1e6)
    """Pictures of left and right that are farther apart make no pair, us."""
    fewest_pairs: int = Field(default=2, ge=1)
    """Pairs of pictures that a distance needs; of one alone nothing tells whether it is right."""

    @model_validator(mode="after")
    def _says_where_the_left_rig_is(self) -> Self:
        parts = self.distance_mm, self.rotation_vector, self.translation_mm
        given = [part is not None for part in parts]
        if given not in ([True, False, False], [False, True, True]):
            raise ValueError(
                "give distance_mm, or rotation_vector and translation_mm of right_from_left: "
                "the one or the other"
            )
        self.frame()
        return self

    def frame(self) -> "TrackFrame":
        """Return the frame that holds both rigs.

        Raises
        ------
        ValueError
            If rig y does not point to the field on both sides.
        """
        # Half a second that only a station with sensors on both sides needs to spend.
        import numpy as np  # noqa: PLC0415  see the line above

        from calib import RigidTransform  # noqa: PLC0415
        from measure import TrackFrame  # noqa: PLC0415

        if self.distance_mm is not None:
            return TrackFrame.of_distance(
                self.distance_mm,
                sigma_mm=self.sigma_distance_mm,
                sigma_turn_rad=self.sigma_turn_rad,
            )
        right_from_left = RigidTransform.from_rotation_vector(
            self.rotation_vector or (0.0,) * 3, self.translation_mm or (0.0,) * 3
        )
        sigmas = np.array([self.sigma_turn_rad] * 3 + [self.sigma_distance_mm] * 3)
        return TrackFrame(right_from_left, np.diag(sigmas**2))
