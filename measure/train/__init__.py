"""From the wheels of a pass to the axles of a train, and from pass to pass."""

from measure.train.assembly import Axle, WheelOfAxle, assemble_train
from measure.train.differences import COMPARED, Difference, Spread, difference, spread
from measure.train.numbers import Placing
from measure.train.tracks import SeenWheel, Side, Track
from measure.train.trend import Jump, Rate, Trend, TrendPoint, fit_trend, jump_between

__all__ = [
    "COMPARED",
    "Axle",
    "Difference",
    "Jump",
    "Placing",
    "Rate",
    "SeenWheel",
    "Side",
    "Spread",
    "Track",
    "Trend",
    "TrendPoint",
    "WheelOfAxle",
    "assemble_train",
    "difference",
    "fit_trend",
    "jump_between",
    "spread",
]
