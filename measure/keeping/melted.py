"""Where two stripes have run into one: it is wider there than a sheet of one thickness draws it."""

import numpy as np
from scipy.spatial import cKDTree

from calib import BoolArray, StripePoints

# Steep faces show a stripe narrower by a third; clipping and flare widen it by a quarter.
_WIDER, _WIDER_IF_CLIPPED = 1.4, 1.5
_SKIRT_PX = 6.0


def melted(stripe: StripePoints) -> BoolArray:
    """Tell which points of one stripe lie where another light has run into it.

    Parameters
    ----------
    stripe
        Points that make one profile.

    Returns
    -------
    leave_out
        Shape (N,): points that are too wide, and those within 6 px of three of them: two stripes
        draw one another aside before they show as a wide one. None where most are alike wide.
    """
    if len(stripe) == 0:
        return np.zeros(0, dtype=bool)
    usual = float(np.median(stripe.width_px))
    wide = stripe.width_px > usual * np.where(stripe.saturated, _WIDER_IF_CLIPPED, _WIDER)
    if wide.sum() < 3:
        return wide
    tree = cKDTree(stripe.centre_px[wide])
    third_px = np.asarray(tree.query(stripe.centre_px, k=[3])[0])[:, 0]
    return np.asarray(wide | (third_px <= _SKIRT_PX))
