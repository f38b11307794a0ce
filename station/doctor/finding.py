"""What a check found: fine, or what to type."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Finding:
    """The outcome of one check."""

    name: str
    seen: str
    """The figures it rests on."""
    cure: str | None = None
    """What to type or to do; None where all is fine."""

    def __post_init__(self) -> None:
        if not (self.name and self.seen and self.cure != ""):
            raise ValueError(f"a finding has a name, what was seen, and a cure or none: {self}")

    @property
    def fine(self) -> bool:
        """Nothing would be lost for this reason."""
        return self.cure is None

    def to_json(self) -> dict[str, str | bool | None]:
        """Return it as the command line prints it."""
        return {"name": self.name, "fine": self.fine, "seen": self.seen, "cure": self.cure}


def judged(name: str, seen: str, *, good: bool, cure: str) -> Finding:
    """Return a finding that holds the cure only where it is needed."""
    return Finding(name, seen, None if good else cure)


def megabytes(count: float) -> str:
    """Return a number of bytes as people read it."""
    return f"{count / 1e6:.3g} MB" if count < 1e9 else f"{count / 1e9:.3g} GB"
