"""From a stripe on a wheel to gauge readings with their uncertainty.  Pure mathematics, mm."""

from measure.analytic_references import reference_profile
from measure.errors import (
    MeasureError,
    PieceInvalid,
    ProfileTextInvalid,
    ReferenceInvalid,
    ReferenceUnknown,
)
from measure.gauging.levels import EN_15313, GaugeLevels
from measure.grouping import each_wheel, group_into_wheels
from measure.limits import PRESETS, Limit, Limits
from measure.mounting import Mounting, Survey
from measure.piece import (
    Piece,
    PieceDeviation,
    PieceFace,
    PieceJudgement,
    PiecePlace,
    PieceReading,
    PieceVerdict,
    judge_piece,
)
from measure.profile import Profile
from measure.profiles.gauged import gauge_profile
from measure.profiles.miniprof import MiniProfText, ascii_fields, format_miniprof, parse_miniprof
from measure.profiles.new_wheel import (
    NOMINAL,
    REFERENCE_STEP_MM,
    REFERENCE_WINDOW_MM,
    MeasuredReference,
    NewWheel,
    reference_of_new_wheels,
)
from measure.profiles.text import parse_profile_csv, parse_profile_text
from measure.quantities import Alarm, Quantity, Reading, Status
from measure.reference import ReferenceProfile
from measure.train import (
    COMPARED,
    Axle,
    Difference,
    Jump,
    Placing,
    Rate,
    SeenWheel,
    Side,
    Spread,
    Track,
    Trend,
    TrendPoint,
    WheelOfAxle,
    assemble_train,
    difference,
    fit_trend,
    jump_between,
    spread,
)
from measure.place import TreadPoint, WheelPlace
from measure.shot import MAX_SKEW_S, Shot, WheelFrame, each_shot, group_into_shots
from measure.wheel import (
    SensorShare,
    WheelQuality,
    WheelReadings,
    measure_wheel,
    measure_wheel_on_rig,
)

__all__ = [
    "REFERENCE_STEP_MM",
    "REFERENCE_WINDOW_MM",
    "COMPARED",
    "EN_15313",
    "NOMINAL",
    "PRESETS",
    "Alarm",
    "Axle",
    "Difference",
    "GaugeLevels",
    "Jump",
    "Limit",
    "Limits",
    "MeasureError",
    "MeasuredReference",
    "MiniProfText",
    "Mounting",
    "Survey",
    "NewWheel",
    "Piece",
    "PieceDeviation",
    "PieceFace",
    "PieceInvalid",
    "PieceJudgement",
    "PiecePlace",
    "PieceReading",
    "PieceVerdict",
    "Placing",
    "Profile",
    "ProfileTextInvalid",
    "Quantity",
    "Rate",
    "Reading",
    "ReferenceInvalid",
    "ReferenceProfile",
    "ReferenceUnknown",
    "SeenWheel",
    "Side",
    "Spread",
    "Status",
    "Track",
    "Trend",
    "TrendPoint",
    "WheelFrame",
    "WheelOfAxle",
    "WheelQuality",
    "WheelReadings",
    "ascii_fields",
    "assemble_train",
    "difference",
    "each_wheel",
    "fit_trend",
    "format_miniprof",
    "gauge_profile",
    "group_into_wheels",
    "judge_piece",
    "jump_between",
    "measure_wheel",
    "measure_wheel_on_rig",
    "MAX_SKEW_S",
    "SensorShare",
    "Shot",
    "TreadPoint",
    "WheelPlace",
    "each_shot",
    "group_into_shots",
    "parse_miniprof",
    "parse_profile_csv",
    "parse_profile_text",
    "reference_of_new_wheels",
    "reference_profile",
    "spread",
]
