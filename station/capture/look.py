"""A picture that a camera took and nobody recorded."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Self


@dataclass(frozen=True, slots=True)
class Look:
    """A picture, shape (height, width), 8 bit, in memory; as a context manager it is let go."""

    descriptor: int
    width: int
    height: int
    received_ns: int
    """When it was received, by this host's clock, UTC."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Let go of the memory; once."""
        os.close(self.descriptor)

    def to_json(self) -> dict[str, int]:
        """Return what goes beside the descriptor."""
        return {"width": self.width, "height": self.height, "received_ns": self.received_ns}

    @classmethod
    def from_json(cls, fields: Mapping[str, Any], descriptor: int) -> Self:
        """Make it of what `to_json` returned and the descriptor as it came."""
        return cls(descriptor, **fields)
