"""The kinds of scenes a simulated camera can stand before."""

from enum import StrEnum


class SceneKind(StrEnum):
    """What stands before the camera."""

    TARGET = "target"
    WHEEL = "wheel"
    CYLINDER = "cylinder"
