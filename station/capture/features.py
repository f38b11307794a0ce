"""GenICam features of an open camera: checked against what it takes, written, read back.

A camera may round a value, take it and ignore it, or change it when another is set.  So each is
compared after writing, and all of them once more when everything is set.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeGuard

from station.capture.aravis import Aravis, GLib
from station.errors import CameraRefused

Value = bool | int | float | str

_ROUNDING = 0.01
"""Cameras round times and rates to their own clock; beyond a hundredth it is another value."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """A setting and the features that may hold it, by the names that cameras use."""

    setting: str
    """Where it stands in the sensor's settings."""
    names: tuple[str, ...]
    value: Value
    under: tuple[str, str] | None = None
    """The selector that says which one is meant, and its entry."""


class Features:
    """The features of one camera.

    Every method raises CameraRefused where the camera has no such feature or does not take the
    value, in one line: what was asked, what is allowed, what to do.
    """

    def __init__(self, device: Any, address: str) -> None:
        self._device = device
        self._address = address

    def has(self, name: str) -> bool:
        """Return whether the camera has the feature, and it is not switched off."""
        try:
            return bool(self._device.is_feature_available(name))
        except GLib.Error:
            return False

    def set(self, wanted: Wanted) -> None:
        """Check a value, write it, and read it back."""
        self._select(wanted)
        name = self._name(wanted)
        if isinstance(self._device.get_feature(name), Aravis.GcCommand):
            self._execute(wanted, name)
            return
        self._ensure_writable(wanted, name)
        self._ensure_allowed(wanted, name)
        try:
            self._write(name, wanted.value)
        except GLib.Error as error:
            raise self._refusal(wanted, name, f"it answers {error.message!r}") from error
        self.ensure_holds(wanted)

    def ensure_holds(self, wanted: Wanted) -> None:
        """Check that the camera has the value it was given."""
        self._select(wanted)
        name = self._name(wanted)
        if isinstance(self._device.get_feature(name), Aravis.GcCommand):
            return
        found = self.get(name)
        if not same(found, wanted.value, self._increment(name)):
            raise self._refusal(wanted, name, f"it holds {_text(found)} after it was set")

    def get(self, name: str) -> Value:
        """Return the value of a feature."""
        device, node = self._device, self._device.get_feature(name)
        if isinstance(node, Aravis.GcEnumeration):
            return str(device.get_string_feature_value(name))
        if isinstance(node, Aravis.GcBoolean):
            return bool(device.get_boolean_feature_value(name))
        if isinstance(node, Aravis.GcFloat):
            return float(device.get_float_feature_value(name))
        if isinstance(node, Aravis.GcInteger):
            return int(device.get_integer_feature_value(name))
        return str(device.get_string_feature_value(name))

    def range_of(self, name: str) -> tuple[int, int, int]:
        """Return the smallest and the largest value of an integer feature, and its step."""
        low, high = self._device.get_integer_feature_bounds(name)
        return low, high, max(1, self._device.get_integer_feature_increment(name))

    def name_of(self, names: Sequence[str]) -> str | None:
        """Return the first of the names that the camera has."""
        return next((name for name in names if self.has(name)), None)

    def _select(self, wanted: Wanted) -> None:
        if wanted.under is not None:
            selector, entry = wanted.under
            self.set(Wanted(wanted.setting, (selector,), entry))

    def _name(self, wanted: Wanted) -> str:
        name = self.name_of(wanted.names)
        if name is None:
            raise CameraRefused(
                f"{wanted.setting} = {_text(wanted.value)} is asked of camera {self._address}; it "
                f"has no feature {' or '.join(wanted.names)}: take the setting out, or look into "
                "the camera's manual for its name"
            )
        return name

    def _execute(self, wanted: Wanted, name: str) -> None:
        if wanted.value is not True:
            raise self._refusal(wanted, name, "it is a command and takes true")
        self._device.execute_command(name)

    def _ensure_writable(self, wanted: Wanted, name: str) -> None:
        if self._device.get_feature_access_mode(name) == Aravis.GcAccessMode.RO:
            raise self._refusal(wanted, name, f"it can only be read and is {self.get(name)}")

    def _ensure_allowed(self, wanted: Wanted, name: str) -> None:
        value, node = wanted.value, self._device.get_feature(name)
        if isinstance(node, Aravis.GcEnumeration):
            allowed = self._device.dup_available_enumeration_feature_values_as_strings(name)
            good, takes = value in allowed, f"one of {', '.join(allowed)}"
        elif isinstance(node, Aravis.GcBoolean):
            good, takes = isinstance(value, bool), "true or false"
        elif isinstance(node, Aravis.GcFloat):
            low, high = self._device.get_float_feature_bounds(name)
            good, takes = is_number(value) and low <= value <= high, f"{low:g} to {high:g}"
        elif isinstance(node, Aravis.GcInteger):
            good, takes = self._integer_allowed(name, value)
        else:
            good, takes = isinstance(value, str), "a text"
        if not good:
            raise self._refusal(wanted, name, f"it takes {takes}")

    def _integer_allowed(self, name: str, value: Value) -> tuple[bool, str]:
        low, high, step = self.range_of(name)
        if isinstance(value, int) and not isinstance(value, bool):
            good = low <= value <= high and (value - low) % step == 0
        else:
            good = False
        return good, f"{low} to {high}" + (f" in steps of {step}" if step > 1 else "")

    def _write(self, name: str, value: Value) -> None:
        device, node = self._device, self._device.get_feature(name)
        if isinstance(node, Aravis.GcBoolean):
            device.set_boolean_feature_value(name, value)
        elif isinstance(node, Aravis.GcEnumeration):
            device.set_string_feature_value(name, value)
        elif isinstance(node, Aravis.GcFloat):
            device.set_float_feature_value(name, value)
        elif isinstance(node, Aravis.GcInteger):
            device.set_integer_feature_value(name, value)
        else:
            device.set_string_feature_value(name, value)

    def _increment(self, name: str) -> float:
        if not isinstance(self._device.get_feature(name), Aravis.GcFloat):
            return 0.0
        try:
            step = float(self._device.get_float_feature_increment(name))
        except GLib.Error:
            return 0.0
        # Where the camera names none, Aravis gives the smallest number there is.
        return step if step > 1e-9 else 0.0

    def _refusal(self, wanted: Wanted, name: str, why: str) -> CameraRefused:
        return CameraRefused(
            f"{wanted.setting} = {_text(wanted.value)} is asked of {name} of camera "
            f"{self._address}; {why}: change the sensor's settings"
        )


def same(found: Value, wanted: Value, increment: float = 0.0) -> bool:
    """Return whether a camera has what it was asked for, but for its rounding.

    Examples
    --------
    >>> same(1000.4, 1000.0), same(1020.0, 1000.0), same(1020.0, 1000.0, increment=20.0)
    (True, False, True)
    >>> same("Off", "On"), same(True, True), same(4, 5)
    (False, True, False)
    """
    if isinstance(found, float) and is_number(wanted):
        tolerance = max(increment, _ROUNDING * abs(wanted))
        return math.isclose(found, wanted, rel_tol=0.0, abs_tol=tolerance)
    return found == wanted


def is_number(value: Value) -> TypeGuard[float]:
    """Return whether a value is a number, which a bool is not."""
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _text(value: Value) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, float) else str(value)
