"""A sensor's settings as features of its camera, in the order in which cameras take them.

Exposure, gain, frame rate and packets are `CommonSettings`; the rest goes by the names of SFNC and
the older ones.
"""

from collections.abc import Iterator

from station.capture.features import Features, Wanted
from station.capture.plan import Trigger
from station.settings import RegionSettings, SensorSettings

_BLACK_LEVEL = ("BlackLevel", "BlackLevelRaw", "BlackLevelAbs")
_TRIGGER_DELAY = ("TriggerDelay", "TriggerDelayAbs")
_DEBOUNCER = ("LineDebouncerTime", "LineDebouncerTimeAbs")
_OUTPUT = ("UserOutputValue",)

REPORTED = (
    "OffsetX",
    "OffsetY",
    "BinningHorizontal",
    "BinningVertical",
    "BlackLevel",
    "BlackLevelRaw",
    "TriggerSource",
    "TriggerActivation",
    "TriggerDelay",
    "TriggerDelayAbs",
    "LineDebouncerTime",
    "LineDebouncerTimeAbs",
)
"""What a recording says of its camera, beside what the settings name; a camera has some of them."""


def set_up(features: Features, settings: SensorSettings) -> tuple[Wanted, ...]:
    """Set everything that goes by its name; return what the camera must hold from now on.

    Raises
    ------
    CameraRefused
        If the camera lacks a feature, or does not take or keep a value.
    """
    others = [
        Wanted(f"features.{name}", (name,), value) for name, value in settings.features.items()
    ]
    kept = []
    for wanted in [*others, *_binning(settings.region)]:
        features.set(wanted)
        kept.append(wanted)
    for wanted in _region(features, settings.region):
        features.set(wanted)
        # The offset is put to 0 on the way; what counts is the last.
        kept = [one for one in kept if one.names != wanted.names or one in others] + [wanted]
    for wanted in _levels(settings):
        features.set(wanted)
        kept.append(wanted)
    return tuple(kept)


def switched(output: str, on: bool, setting: str) -> Wanted:
    """Return what puts a user output to a level."""
    return Wanted(setting, _OUTPUT, on, under=("UserOutputSelector", output))


def of_trigger(settings: SensorSettings, trigger: Trigger) -> Iterator[Wanted]:
    """Yield what is set once the camera waits for triggers; setting a trigger resets them."""
    if trigger is Trigger.LINE1 and settings.trigger_activation is not None:
        activation = settings.trigger_activation
        yield Wanted("trigger_activation", ("TriggerActivation",), activation)
    if trigger is not Trigger.FREE and settings.trigger_delay_us is not None:
        yield Wanted("trigger_delay_us", _TRIGGER_DELAY, settings.trigger_delay_us)


def _binning(region: RegionSettings) -> Iterator[Wanted]:
    # First of all: it decides how large the region can be.
    if region.binning_x is not None:
        yield Wanted("region.binning_x", ("BinningHorizontal",), region.binning_x)
    if region.binning_y is not None:
        yield Wanted("region.binning_y", ("BinningVertical",), region.binning_y)


def _region(features: Features, region: RegionSettings) -> Iterator[Wanted]:
    """Yield offset 0, the size, the offset: a size is only taken where the offset leaves room."""
    axes = (
        ("x", "Width", "OffsetX", region.offset_x_px, region.width_px),
        ("y", "Height", "OffsetY", region.offset_y_px, region.height_px),
    )
    for axis, size_name, offset_name, offset_px, size_px in axes:
        offset_setting = f"region.offset_{axis}_px"
        if features.has(offset_name):
            yield Wanted(offset_setting, (offset_name,), 0)
        size_setting = f"region.{size_name.lower()}_px"
        if size_px is None:
            low, high, step = features.range_of(size_name)
            size_px = max(low, low + (high - offset_px - low) // step * step)
        yield Wanted(size_setting, (size_name,), size_px)
        if offset_px:
            yield Wanted(offset_setting, (offset_name,), offset_px)


def _levels(settings: SensorSettings) -> Iterator[Wanted]:
    if settings.black_level is not None:
        yield Wanted("black_level", _BLACK_LEVEL, settings.black_level)
    if settings.trigger_debounce_us is not None:
        line = ("LineSelector", "Line1")
        yield Wanted("trigger_debounce_us", _DEBOUNCER, settings.trigger_debounce_us, under=line)
    for output, on in settings.outputs.items():
        yield switched(output, on, f"outputs.{output}")
    if settings.laser_output is not None:
        yield switched(settings.laser_output, True, "laser_output")
