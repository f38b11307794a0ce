"""Which ridge points of a picture lie on the section of a cylinder of known nominal radius."""

import numpy as np
from scipy.spatial import KDTree

from calib.arrays import BoolArray, FloatArray
from calib.sensor import LaserSensor
from calib.sheet_frame import SheetFrame
from calib.views import StripePoints

# Parts of the nominal radius. A tilt of 20 degrees makes the section 6 % longer than wide and
# turns its normals by up to 3.5 degrees, which moves a vote for its centre by 6 %.
_VOTE_REACH = 0.08
_MEMBER_REACH = 0.10
# The normal of a point of the section, against the direction to the centre.
_ALIKE = 0.95
# What only crosses the section has most of its neighbours off it.
_NEIGHBOURS_PX = 15.0
_MOSTLY = 0.5
# Over one cylinder the focus, and so the width of the stripe, changes by far less.
_WIDTHS_ALIKE = 2.0
_FAINTEST = 1.0 / 3.0


def points_of_arc(
    stripe: StripePoints, sensor: LaserSensor, frame: SheetFrame, radius_mm: float
) -> tuple[BoolArray, FloatArray]:
    """Return the points that most nearly make a circle of a radius on the sheet.

    Parameters
    ----------
    stripe
        All ridge points of a picture.
    sensor, frame
        Where they lie on the sheet.
    radius_mm
        Nominal radius.

    Returns
    -------
    on_arc
        Shape (N,); all False where there are no points.
    centre_mm
        Shape (2,), rough, on the sheet.

    Notes
    -----
    Each point votes for the two centres at the radius along its own normal; the centre with most
    votes nearby is taken. Straight edges and texture vote all over the place.
    """
    none = np.zeros(len(stripe), dtype=bool)
    place, normal = on_sheet(stripe, sensor, frame)
    found = np.flatnonzero(np.isfinite(place).all(axis=1) & np.isfinite(normal).all(axis=1))
    if found.size == 0:
        return none, np.zeros(2)
    place, normal = place[found], normal[found]
    votes = np.concatenate([place + radius_mm * normal, place - radius_mm * normal])
    tree = KDTree(votes)
    near = tree.query_ball_point(votes, _VOTE_REACH * radius_mm, return_length=True)
    most = votes[int(np.argmax(near))]
    centre = votes[tree.query_ball_point(most, _VOTE_REACH * radius_mm)].mean(axis=0)
    towards = place - centre
    distance = np.linalg.norm(towards, axis=1)
    aligned = np.abs((towards * normal).sum(axis=1)) > _ALIKE * distance
    member = aligned & (np.abs(distance - radius_mm) < _MEMBER_REACH * radius_mm)
    on_arc = none
    on_arc[found[member]] = True
    on_arc = _like_the_others(stripe, on_arc)
    return _among_their_like(stripe.centre_px, on_arc), np.asarray(centre)


def _among_their_like(centre_px: FloatArray, member: BoolArray) -> BoolArray:
    """Tell the members whose neighbours are mostly members too.

    An edge that crosses the section shares a few points with it, at its ends the worst: they are
    far from the others and turn it.
    """
    if not member.any():
        return member
    all_points, members = KDTree(centre_px), KDTree(centre_px[member])
    near = all_points.query_ball_point(centre_px, _NEIGHBOURS_PX, return_length=True)
    alike = members.query_ball_point(centre_px, _NEIGHBOURS_PX, return_length=True)
    return np.asarray(member & (alike >= _MOSTLY * near))


def _like_the_others(stripe: StripePoints, among: BoolArray) -> BoolArray:
    """Tell the points as wide as most, and not much dimmer.

    The edge of a lit surface is wider. Where the sheet grazes the surface the stripe fades within
    its own width, and its centres are drawn to the bright side.
    """
    if not among.any():
        return among
    width = stripe.width_px / np.median(stripe.width_px[among])
    height = stripe.peak / np.median(stripe.peak[among])
    alike = (width < _WIDTHS_ALIKE) & (width > 1.0 / _WIDTHS_ALIKE) & (height > _FAINTEST)
    return np.asarray(among & alike)


def on_sheet(
    stripe: StripePoints, sensor: LaserSensor, frame: SheetFrame
) -> tuple[FloatArray, FloatArray]:
    """Return places and unit normals of a stripe on the sheet, both shape (N, 2), NaN off it."""
    by_pixel, _ = sensor.location_jacobians(stripe.centre_px)
    along_px = np.column_stack([-stripe.normal[:, 1], stripe.normal[:, 0]])
    along = (by_pixel @ along_px[:, :, None])[:, :, 0] @ frame.axes_in_cam.T
    normal = np.column_stack([-along[:, 1], along[:, 0]])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return frame.coordinates(sensor.locate(stripe.centre_px)), normal
