"""The trains that pass: axles of what the sensors saw, their consist, and how wheels change."""

from station.trains.alarms import AlarmKind, AxleAlarm
from station.trains.consist import Consist, Named, Orientation, Wheelset
from station.trains.keeping import keep_axles
from station.trains.picture import (
    AxlePicture,
    QuantityDifference,
    TrainPicture,
    VehicleSpread,
    WheelPicture,
    train_picture,
)
from station.trains.trends import (
    QuantityTrend,
    SideTrend,
    TrendValue,
    WheelsetTrend,
    wheelset_trend,
)

__all__ = [
    "AlarmKind",
    "AxleAlarm",
    "AxlePicture",
    "Consist",
    "Named",
    "Orientation",
    "QuantityDifference",
    "QuantityTrend",
    "SideTrend",
    "TrainPicture",
    "TrendValue",
    "VehicleSpread",
    "WheelPicture",
    "Wheelset",
    "WheelsetTrend",
    "keep_axles",
    "train_picture",
    "wheelset_trend",
]
