"""The lights under which a picture is taken: a good one and the six bad ones of the paper's Fig. 8.

Levels are counts at exposure 1 over the dark level; 252 counts fill the converter.
"""

from dataclasses import dataclass
from enum import StrEnum


class Light(StrEnum):
    """What the light does to a picture."""

    GOOD = "good"
    REFLECTION = "reflection"
    OVER_EXPOSED = "over-exposed"
    CROSSING = "crossing"
    DIM = "dim"
    STRAY = "stray"
    BRIGHT_BACKGROUND = "bright-background"


@dataclass(frozen=True, slots=True)
class LightRecipe:
    """The levels that make a light.

    Attributes
    ----------
    lamps
        Level of a lit dot.
    lamps_fall
        Share of the lamps' light lost from one side of the target to the other.
    stripe
        Level of the stripe on the metal of a target, and on a matt surface square to the laser.
    stripe_unevenness
        Standard deviation over mean of the laser's brightness along its fan.
    daylight
        Level of a white surface in the light of the surroundings.
    sun
        Level the sun adds to a white surface; a shadow's edge crosses the target.
    shine
        Level of the sun's or a lamp's reflection on metal at its middle.
    surroundings
        Level of what stands behind.
    false_stripe
        Brightness of a second sheet, thrown by a reflection, over that of the first.
    stray_spots
        Number of spots of light scattered over the picture.
    """

    lamps: float = 150.0
    lamps_fall: float = 0.0
    stripe: float = 240.0
    stripe_unevenness: float = 0.06
    daylight: float = 14.0
    sun: float = 0.0
    shine: float = 0.0
    surroundings: float = 6.0
    false_stripe: float = 0.0
    stray_spots: int = 0


RECIPES = {
    Light.GOOD: LightRecipe(),
    Light.REFLECTION: LightRecipe(shine=190.0, daylight=40.0, surroundings=12.0),
    # Four times the exposure that the dots want, under a reflection that alone would fill the
    # converter.
    Light.OVER_EXPOSED: LightRecipe(
        lamps=600.0, stripe=1000.0, shine=420.0, daylight=110.0, surroundings=30.0
    ),
    # A laser strong enough that a dot it crosses melts together with the stripe.
    Light.CROSSING: LightRecipe(stripe=400.0),
    Light.DIM: LightRecipe(
        lamps=16.0, lamps_fall=0.6, stripe=36.0, stripe_unevenness=0.35, daylight=5.0
    ),
    Light.STRAY: LightRecipe(
        stripe=2000.0, false_stripe=1.0, stray_spots=14, daylight=25.0, surroundings=10.0
    ),
    Light.BRIGHT_BACKGROUND: LightRecipe(
        lamps=130.0, daylight=160.0, sun=260.0, surroundings=150.0, stripe=220.0
    ),
}
