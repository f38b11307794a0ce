"""What the viewing process is asked for, and what it gives."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any, Self


class Form(StrEnum):
    """In which form a frame is wanted."""

    JPEG = "jpeg"
    """The picture, small enough to come five times a second."""
    PNG = "png"
    """The picture, exact to the count where it is not made smaller."""
    VIEW = "view"
    """A JSON document: the picture, the stripe found on it, how bright and how sharp it is."""
    STRIPE = "stripe"
    """The same document without the picture."""
    TIMELINE = "timeline"
    """A JSON document of a whole recording that is finished: how its frames and events lie in time.
    """

    @property
    def media_type(self) -> str:
        """Media type of what is given."""
        return f"image/{self}" if self in {Form.JPEG, Form.PNG} else "application/json"


@dataclass(frozen=True, slots=True)
class SharedPicture:
    """A picture in memory that another process shares; its descriptor goes along."""

    descriptor: int
    width: int
    height: int
    received_ns: int
    """When it was received, by the host's clock, UTC."""

    def __post_init__(self) -> None:
        if not (self.width > 0 and self.height > 0):
            raise ValueError(f"a picture is not {self.width} x {self.height} pixels large")


@dataclass(frozen=True, slots=True)
class ViewOrder:
    """Which frame is wanted, and how.

    Raises
    ------
    ValueError
        If it names both a recording and a shared picture, or neither.
    """

    form: Form
    recording: Path | None = None
    """The first file of a recording, by the name it has once it is finished."""
    shared: SharedPicture | None = None
    """In place of a recording: a picture that is in none."""
    growing: bool = False
    """Whether the recording is still being made; its newest frame is given."""
    number: int | None = None
    """Which frame of a recording that is finished, from 1; its last where None."""
    known: int | None = None
    """The number of the frame that the caller has: that one is not given again."""
    max_width: int | None = None
    """A wider picture is made smaller, px."""
    about: Mapping[str, str | None] = field(default_factory=dict)
    """What a document says besides, as the name of the recording."""
    frame_ids: tuple[int, ...] = ()
    """Frames whose places a time line is to tell, as the camera numbers them."""

    def __post_init__(self) -> None:
        if (self.recording is None) == (self.shared is None):
            raise ValueError("give a recording or a shared picture, and not both")

    def to_json(self) -> dict[str, Any]:
        """Return the order as it goes to the viewing process."""
        recording = None if self.recording is None else str(self.recording)
        return {**asdict(self), "recording": recording}

    @classmethod
    def from_json(cls, fields: Mapping[str, Any], descriptor: int | None) -> Self:
        """Make an order of what `to_json` returned; a descriptor has another number here."""
        path, shared = fields["recording"], fields["shared"]
        if shared is not None:
            shared = SharedPicture(**{**shared, "descriptor": descriptor})
        known = {
            "form": Form(fields["form"]),
            "recording": None if path is None else Path(path),
            "shared": shared,
            "frame_ids": tuple(fields["frame_ids"]),
        }
        return cls(**{**fields, **known})


@dataclass(frozen=True, slots=True)
class SeenFrame:
    """Which frame is seen."""

    number: int | None
    """Its place in its recording, from 1; None where it is in none."""
    frame_id: int | None
    """As the camera numbers them."""
    time_ns: int
    """When it was exposed, UTC; when it was received, where nothing tells that."""
    received_ns: int
    """When it was received, by the host's clock, UTC."""


@dataclass(frozen=True, slots=True)
class View:
    """A frame in the form that was asked for."""

    frame: SeenFrame
    form: Form
    content: bytes
