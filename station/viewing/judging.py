"""How bright a picture is, and what the stripe on it looks like: to aim, to focus, to expose."""

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np

from calib import Picture, StripePoints

_LEVELS = 256
_MOST_POINTS = 400
"""Points drawn over a picture: more of them cannot be told apart on a screen."""
_NEARLY_ALL = 0.999


@dataclass(frozen=True, slots=True)
class Brightness:
    """How the counts of a picture are spread."""

    max_counts: int
    p999_counts: int
    """So bright or darker are 99.9 % of the pixels."""
    clipped_share: float
    """Part of the pixels that are as bright as can be counted, 0 to 1."""

    @classmethod
    def of(cls, picture: Picture) -> "Brightness":
        """Return that of a picture, shape (H, W), 8 bit."""
        counts = cv2.calcHist([picture], [0], None, [_LEVELS], [0, _LEVELS]).ravel()
        up_to = np.cumsum(counts) / picture.size
        return cls(
            max_counts=int(np.flatnonzero(counts)[-1]),
            p999_counts=int(np.searchsorted(up_to, _NEARLY_ALL)),
            clipped_share=float(counts[-1] / picture.size),
        )

    def to_json(self) -> dict[str, Any]:
        """Return it as a document has it."""
        return {
            "max_counts": self.max_counts,
            "p999_counts": self.p999_counts,
            "clipped_share": round(self.clipped_share, 6),
        }


def focus_json(stripe: StripePoints) -> dict[str, Any] | None:
    """Return how sharp a stripe is; None where there is none.

    The lens is in focus where the stripe is narrowest; there its peak is highest, too.  Of clipped
    points the width cannot be told: they count only where there are no others.
    """
    if len(stripe) == 0:
        return None
    clear = ~stripe.saturated
    width_px = stripe.width_px[clear] if clear.any() else stripe.width_px
    return {
        "width_px": round(float(np.median(width_px)), 3),
        "peak_counts": round(float(np.median(stripe.peak)), 1),
        "clipped_share": round(float(np.mean(stripe.saturated)), 4),
    }


def stripe_json(stripe: StripePoints) -> dict[str, Any]:
    """Return the points of a stripe, or as many of them as can be drawn, evenly chosen."""
    count = len(stripe)
    chosen = np.linspace(0, max(count - 1, 0), min(count, _MOST_POINTS)).round().astype(np.int64)
    centre_px = stripe.centre_px[chosen]
    return {
        "points": count,
        "u_px": np.round(centre_px[:, 0], 2).tolist(),
        "v_px": np.round(centre_px[:, 1], 2).tolist(),
        "sigma_px": np.round(stripe.sigma_px[chosen], 4).tolist(),
    }
