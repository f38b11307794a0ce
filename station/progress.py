"""How long work says where it is."""

from collections.abc import Callable

Progress = Callable[[float, str], None]
"""Called with the fraction done, 0 to 1, and what is being done."""


def silent(_fraction: float, _what: str) -> None:
    """Say nothing."""
