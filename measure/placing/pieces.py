"""Which points of a stripe hang together."""

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from calib import FloatArray, IntArray

MIN_PIECE = 12
"""Fewer points than this are a speck, not a piece of stripe."""
_LINK_PX = 4.0
# Where two stripes cross, each goes on in its own direction: 25 degrees keep them apart.
_COS_LINK = 0.906


def pieces(centre_px: FloatArray, normal: FloatArray) -> IntArray:
    """Return the number of the piece that each point belongs to.

    Points belong together that are neighbours in the picture (there, and only there, they are
    evenly spaced) and whose stripes run the same way.

    Parameters
    ----------
    centre_px
        Shape (N, 2).
    normal
        Shape (N, 2), unit, across the stripe.

    Returns
    -------
    piece
        Shape (N,).
    """
    count = len(centre_px)
    if count == 0:
        return np.zeros(0, dtype=np.int64)
    tree = cKDTree(centre_px, balanced_tree=False, compact_nodes=False)  # made to be asked once
    i, j = tree.query_pairs(_LINK_PX, output_type="ndarray").T
    same_way = np.abs(np.sum(normal[i] * normal[j], axis=1)) > _COS_LINK
    i, j = i[same_way], j[same_way]
    links = csr_array((np.ones(len(i)), (i, j)), shape=(count, count))
    return np.asarray(connected_components(links, directed=False)[1], dtype=np.int64)


def sizes(piece: IntArray) -> IntArray:
    """Return the size of the piece that each point belongs to."""
    return np.bincount(piece)[piece] if len(piece) else piece
