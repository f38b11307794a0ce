"""Where the gauges touch a wheel: three lengths by which instruments differ."""

from dataclasses import dataclass

TAPE_D_MM = 70.0
"""Distance of the tape circle from the flange back."""


@dataclass(frozen=True, slots=True)
class GaugeLevels:
    """Where flange height, thickness and gradient are taken; EN 15313 where not said otherwise.

    Attributes
    ----------
    tape_d_mm
        Where the tread's height is taken, from the flange back (MiniProf's L2).
    face_mm
        How far above that the thickness is taken (L3).
    below_tip_mm
        How far below the tip the gradient's upper point is taken (L1).
    """

    tape_d_mm: float = TAPE_D_MM
    face_mm: float = 10.0
    below_tip_mm: float = 2.0

    def __post_init__(self) -> None:
        if not (
            50.0 <= self.tape_d_mm <= 100.0
            and 5.0 <= self.face_mm <= 18.0
            and 0.5 <= self.below_tip_mm <= 8.0
        ):
            raise ValueError(
                f"tape circle at {self.tape_d_mm:g} mm, thickness {self.face_mm:g} above, gradient "
                f"{self.below_tip_mm:g} below the tip; allowed: 50 to 100, 5 to 18, 0.5 to 8"
            )


EN_15313 = GaugeLevels()
"""Flange height at 70 mm, thickness 10 mm above, gradient to 2 mm below the tip."""
