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
from station.trains.tallies import AlarmTally, alarm_tallies
from station.trains.trends import (
    QuantityTrend,
    SideTrend,
    TrendValue,
    WheelsetTrend,
    wheelset_trend,
)
from station.trains.wheels import readings_of

__all__ = [
    "AlarmKind",
    "AlarmTally",
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
    "alarm_tallies",
    "keep_axles",
    "readings_of",
    "train_picture",
    "wheelset_trend",
]
