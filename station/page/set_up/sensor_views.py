"""The sensors: what is set, and what their cameras say of themselves."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from station.capture import CaptureStatus
from station.page.set_up.told import Setting, settings_in, told
from station.settings import SensorSettings, StationSettings

_NOT_OF_CAMERA: Final = frozenset({"id", "side", "address", "mounting", "calibration_exposures"})
_REPORTED_AS: Final[Mapping[str, Sequence[str]]] = {
    "trigger": ("feature.TriggerSource",),
    "exposure_us": ("exposure_us",),
    "gain_db": ("gain_db",),
    "black_level": ("feature.BlackLevel", "feature.BlackLevelRaw"),
    "trigger_activation": ("feature.TriggerActivation",),
    "trigger_delay_us": ("feature.TriggerDelay", "feature.TriggerDelayAbs"),
    "trigger_debounce_us": ("feature.LineDebouncerTime", "feature.LineDebouncerTimeAbs"),
    "frame_rate_hz": ("frame_rate_hz",),
    "packet_size": ("packet_size",),
    "packet_delay_ns": ("packet_delay_ns",),
    "offset_x_px": ("feature.OffsetX",),
    "offset_y_px": ("feature.OffsetY",),
    "width_px": ("width",),
    "height_px": ("height",),
    "binning_x": ("feature.BinningHorizontal",),
    "binning_y": ("feature.BinningVertical",),
}
"""By what names a camera reports a setting: SFNC's, and those of older cameras."""
_SAME_WITHIN: Final = 0.01
"""Cameras round to what their clocks and amplifiers can do."""
_GAIN_STEP_DB: Final = 0.4
"""The coarsest steps of analogue gain."""


@dataclass(frozen=True, slots=True)
class CameraSetting:
    """A setting beside what the camera holds.

    Attributes
    ----------
    held
        None where the camera does not say.
    asked
        Whether cameras are asked for it at all.
    """

    setting: Setting
    held: str | None
    differs: bool
    asked: bool


@dataclass(frozen=True, slots=True)
class SensorView:
    """A sensor: its settings in force and its camera.

    Attributes
    ----------
    identity
        What the camera says it is; empty where it was never open.
    state
        Of its capture process; None where that does not answer.
    problem
        Why the camera is not open.
    rig
        The rig that it is in; None where it is measured by itself.
    """

    id: str
    side: str
    address: str
    rig: str | None
    state: str | None
    problem: str | None
    warnings: Sequence[str]
    identity: Mapping[str, str]
    temperature_c: float | None
    settings: Sequence[CameraSetting]
    mounting: Sequence[Setting]

    @property
    def differing(self) -> int:
        """How many settings the camera does not hold."""
        return sum(each.differs for each in self.settings)


def sensor_views(
    settings: StationSettings, statuses: Mapping[str, CaptureStatus]
) -> list[SensorView]:
    """Return the sensors in the order of the settings.

    Parameters
    ----------
    statuses
        Of the capture processes that answer, by sensor.
    """
    return [_view(settings, sensor, statuses.get(sensor.id)) for sensor in settings.sensors]


def _view(
    settings: StationSettings, sensor: SensorSettings, status: CaptureStatus | None
) -> SensorView:
    camera = {} if status is None else status.camera
    rig = settings.rig_with(sensor.id)
    place = f"sensors.{sensor.id}"
    mounting = sensor.mounting
    return SensorView(
        id=sensor.id,
        side=sensor.side,
        address=sensor.address,
        rig=None if rig is None else rig.id,
        state=None if status is None else str(status.state),
        problem=None if status is None else status.problem,
        warnings=() if status is None else status.warnings,
        identity={name: camera[name] for name in ("vendor", "model", "serial") if name in camera},
        temperature_c=None if status is None else status.temperature_c,
        settings=[_compared(each, sensor, camera) for each in _of_camera(sensor, place)],
        mounting=[] if mounting is None else settings_in(mounting, f"{place}.mounting"),
    )


def _of_camera(sensor: SensorSettings, place: str) -> list[Setting]:
    features = [
        Setting(name, f"{place}.features.{name}", told("", value), named=False)
        for name, value in sensor.features.items()
    ]
    outputs = [
        Setting(name, f"{place}.outputs.{name}", told("", value), named=False)
        for name, value in sensor.outputs.items()
    ]
    return [
        *settings_in(sensor, place, but=_NOT_OF_CAMERA),
        *settings_in(sensor.region, f"{place}.region"),
        *outputs,
        *features,
    ]


def _compared(setting: Setting, sensor: SensorSettings, camera: Mapping[str, str]) -> CameraSetting:
    names = _REPORTED_AS.get(setting.name, (f"feature.{setting.name}",))
    held = next((camera[name] for name in names if name in camera), None)
    wanted = _wanted(setting.name, sensor)
    differs = None not in {held, wanted} and not _same(setting.name, str(wanted), str(held))
    asked = setting.name in _REPORTED_AS or not setting.named
    return CameraSetting(setting, told(setting.name, _number(held)), differs, asked)


def _wanted(name: str, sensor: SensorSettings) -> object:
    """Return what a camera is to hold; None where that is left to it."""
    if name == "trigger":
        # One that runs free keeps whatever source it was given before.
        return {"software": "Software", "Line1": "Line1"}.get(sensor.trigger)
    if name in sensor.features:
        return sensor.features[name]
    return (
        getattr(sensor, name, None) if hasattr(sensor, name) else getattr(sensor.region, name, None)
    )


def _same(name: str, wanted: str, held: str) -> bool:
    """Tell whether a camera holds what it was asked for, as near as cameras can.

    >>> _same("exposure_us", "500.0", "499.2"), _same("packet_size", "9000", "1500")
    (True, False)
    """
    first, second = _number(wanted), _number(held)
    if not (isinstance(first, float) and isinstance(second, float)):
        return str(first).lower() == str(second).lower()
    step = _GAIN_STEP_DB if name == "gain_db" else 0.0
    return abs(first - second) <= max(_SAME_WITHIN * abs(first), step)


def _number(text: str | None) -> float | str | None:
    try:
        return None if text is None else float(text)
    except ValueError:
        return text
