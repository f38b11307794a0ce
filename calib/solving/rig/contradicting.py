"""What is said of showings that contradict the others, and how many of them are too many."""

from calib.errors import Degenerate

# Where more than this part of the showings contradict, none is to be believed.
_MOST_CONTRADICTING = 0.5


def contradiction(miss_mm: float) -> str:
    """Return why a showing that contradicts the others by so much is left out."""
    return (
        f"its pictures contradict the other showings by {miss_mm:.2g} mm: the target moved between "
        "them, or they are not of this target"
    )


def require_agreement(contradicting: int, showings: int) -> None:
    """Refuse showings most of which contradict each other.

    Raises
    ------
    Degenerate
        If it is more than a half.
    """
    if contradicting > _MOST_CONTRADICTING * showings:
        raise Degenerate(
            f"{contradicting} of {showings} showings contradict the others; keep the target still "
            "while all cameras take their picture, and check that its boards are fixed to each "
            "other"
        )
