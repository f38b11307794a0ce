"""When a recording goes on in a next file."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Rotation:
    """When a recording goes on in a next file; it stays in one where neither is given.

    Raises
    ------
    ValueError
        If one is given that is not more than 0.
    """

    seconds: float | None = None
    """After so long since the file's first frame."""
    size_bytes: int | None = None
    """After so many bytes."""

    def __post_init__(self) -> None:
        if not (self.seconds is None or self.seconds > 0.0):
            raise ValueError(f"seconds must be more than 0, got {self.seconds}")
        if not (self.size_bytes is None or self.size_bytes > 0):
            raise ValueError(f"size_bytes must be more than 0, got {self.size_bytes}")

    def due(self, seconds: float, size_bytes: int) -> bool:
        """Whether a file of that age and size is followed by another."""
        old = self.seconds is not None and seconds >= self.seconds
        return old or (self.size_bytes is not None and size_bytes >= self.size_bytes)
