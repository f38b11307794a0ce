"""Points of a stripe laid on a piece: rigidly, robustly, and not beside its edges."""

from dataclasses import dataclass, replace

import numpy as np

from calib import BoolArray, FloatArray, IntArray, LaserSensor, SheetFrame, StripePoints, kernel_of
from measure.laying.bend import bend_px
from measure.laying.section import SheetPoints
from measure.piece.certified import Piece
from measure.piece.match import (
    GATE_MM,
    MIN_POINTS,
    Match,
    explained_mm,
    gate_mm,
    matched,
    settled,
)
from measure.piece.noise import scatter_of
from measure.piece.search import PiecePose, find_piece
from measure.placing.pieces import MIN_PIECE, pieces, sizes

_FARTHEST_SIGMAS = 5.0
# What spreads light along the stripe, and the kernel that reads it, end within three sigmas.
_REACH_SIGMAS = 3.0
_GAP_MM = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class LaidPiece:
    """The points that lie on a piece, in order along its profile.

    Attributes
    ----------
    piece, pose
        What they lie on, and where it lies on the sheet.
    face
        Shape (N,), index of the side of each point.
    along_mm
        Shape (N,), place along its side.
    outside_mm
        Shape (N,), how far out of the certified profile it lies.
    points_mm, normal
        Shape (N, 2), in the piece's frame: the point, and the direction out of the metal.
    sigma_mm
        Shape (N,): standard deviation along the normal as it counts in a mean: speckle in it,
        and what neighbours share.
    by_sensor_mm
        Shape (N, 13): motion along the normal by the sensor's parameters.
    bend_mm
        Shape (N,): what was taken off for the bend of the stripe; on round sides only.
    """

    piece: Piece
    pose: PiecePose
    face: IntArray
    along_mm: FloatArray
    outside_mm: FloatArray
    points_mm: FloatArray
    normal: FloatArray
    sigma_mm: FloatArray
    by_sensor_mm: FloatArray
    bend_mm: FloatArray

    def __len__(self) -> int:
        return len(self.face)

    @property
    def rms_mm(self) -> float:
        """Root mean square of the distances from the profile."""
        return float(np.sqrt(np.mean(self.outside_mm**2)))

    @property
    def turning_mm(self) -> FloatArray:
        """What a small turn about the middle of the points moves each along its normal, (N,)."""
        arm = self.points_mm - self.points_mm.mean(axis=0)
        return np.asarray(self.normal[:, 1] * arm[:, 0] - self.normal[:, 0] * arm[:, 1])

    @property
    def seen_mm(self) -> FloatArray:
        """Length of each side between its outermost points, shape (number of sides,)."""
        spans = [self.along_mm[self.face == k] for k in range(len(self.piece.faces))]
        return np.array([float(np.ptp(span)) if len(span) else 0.0 for span in spans])


def lay_on_piece(stripe: StripePoints, sensor: LaserSensor, piece: Piece) -> LaidPiece | str:
    """Lay the stripe of one picture on a piece, or return why it cannot be.

    Parameters
    ----------
    stripe
        All ridges of the picture; what is not on the piece is left out.
    sensor
        The sensor under test.
    piece
        As large as it is now.
    """
    hanging = stripe.select(sizes(pieces(stripe.centre_px, stripe.normal)) >= MIN_PIECE)
    sheet = SheetPoints.of(hanging, sensor)
    if len(sheet) < MIN_POINTS:
        return f"no stripe: {len(sheet)} points hang together, {MIN_POINTS} are needed"
    frame = SheetFrame.of(sensor.plane)
    place, normal = _on_sheet(sheet, frame)
    found = find_piece(place, normal, piece)
    if not found:
        return f"no piece: nothing in the picture has the profile of {piece.name}"
    fits = [settled(pose, place, normal, piece) for pose in found]
    pose = max(fits, key=lambda fit: explained_mm(fit, place, normal, piece))
    return _laid(pose, sheet, sensor, frame, piece)


def _on_sheet(sheet: SheetPoints, frame: SheetFrame) -> tuple[FloatArray, FloatArray]:
    """Return places on the sheet and unit normals towards the camera, (N, 2) each."""
    place = frame.coordinates(sheet.points_in_cam_mm)
    along = sheet.along_mm @ frame.axes_in_cam.T
    normal = np.column_stack([-along[:, 1], along[:, 0]])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    # The frame's origin is the camera's foot on the sheet: only what faces it is seen.
    return place, normal * np.where((normal * place).sum(axis=1) > 0.0, -1.0, 1.0)[:, None]


def _laid(
    pose: PiecePose, sheet: SheetPoints, sensor: LaserSensor, frame: SheetFrame, piece: Piece
) -> LaidPiece | str:
    """Keep what is fit to be measured, and fit once more to that alone."""
    place, normal = _on_sheet(sheet, frame)
    match = matched(pose.to_piece(place), normal @ pose.turn, piece, gate_mm(piece, GATE_MM))
    kept = _inside(match, sheet, frame, piece)
    if len(kept) < MIN_POINTS:
        return (
            f"{len(kept)} points on the piece away from its edges; {MIN_POINTS} are needed: "
            "show more of it, or a larger one"
        )
    sheet = _unbent(sheet.select(kept), match.face[kept], sensor, piece)
    place, normal = _on_sheet(sheet, frame)
    pose = settled(pose, place, normal, piece)
    match = matched(pose.to_piece(place), normal @ pose.turn, piece, np.inf)
    order = np.lexsort((match.along_mm, match.face))
    order = order[match.face[order] >= 0]
    laid = _measured(pose, match, order, sheet, sensor, frame, piece)
    usual = _usual(laid)
    if usual.sum() < MIN_POINTS:
        return f"{usual.sum()} points agree with each other; {MIN_POINTS} are needed"
    return _measured(pose, match, order[usual], sheet, sensor, frame, piece)


def _inside(match: Match, sheet: SheetPoints, frame: SheetFrame, piece: Piece) -> IntArray:
    """Return the points farther from an edge, or the end of a stretch of stripe, than light bleeds.

    Light of a bright side bleeds over an edge, and a kernel reads across it.
    """
    width = sheet.stripe.width_px
    per_px = np.linalg.norm(sheet.along_mm @ frame.axes_in_cam.T, axis=1)
    reach = _REACH_SIGMAS * np.hypot(width, kernel_of(width)) * per_px
    kept: list[IntArray] = []
    for index, face in enumerate(piece.faces):
        on = np.flatnonzero(match.face == index)
        on = on[np.argsort(match.along_mm[on], kind="stable")]
        along = match.along_mm[on]
        for run in np.split(np.arange(len(on)), np.flatnonzero(np.diff(along) > _GAP_MM) + 1):
            if len(run) < MIN_PIECE:
                continue
            first = max(0.0, along[run[0]]) + reach[on[run]]
            last = min(face.length_mm, along[run[-1]]) - reach[on[run]]
            clear = run[(along[run] >= first) & (along[run] <= last)]
            kept.append(on[clear] if len(clear) >= MIN_PIECE else on[:0])
    return np.concatenate([np.zeros(0, dtype=np.int64), *kept])


def _unbent(sheet: SheetPoints, face: IntArray, sensor: LaserSensor, piece: Piece) -> SheetPoints:
    """Take off what blur does to the stripe on round sides; straight ones it leaves in place."""
    is_round = np.array([one.centre_mm is not None for one in piece.faces])[face]
    if not is_round.any():
        return sheet
    stripe = sheet.stripe
    drawn_px = np.where(is_round, bend_px(stripe), 0.0)
    moved = replace(stripe, centre_px=stripe.centre_px - drawn_px[:, None] * stripe.normal)
    bend = sheet.across_mm * (drawn_px / stripe.sigma_px)[:, None]
    return replace(SheetPoints.of(moved, sensor), bend_mm=bend)


def _measured(
    pose: PiecePose,
    match: Match,
    index: IntArray,
    sheet: SheetPoints,
    sensor: LaserSensor,
    frame: SheetFrame,
    piece: Piece,
) -> LaidPiece:
    """Describe the points of an index array: where they lie, and what may move them."""
    normal = match.normal[index]
    # From a motion in the camera frame to one out of the metal.
    out_in_cam = normal @ pose.turn.T @ frame.axes_in_cam
    own = np.abs((sheet.across_mm[index] * out_in_cam).sum(axis=1))
    stripe = sheet.stripe.select(index)
    outside, along, face = match.outside_mm[index], match.along_mm[index], match.face[index]
    per_px = np.linalg.norm(sheet.along_mm[index] @ frame.axes_in_cam.T, axis=1)
    terms = [2 if side.centre_mm is None else 3 for side in piece.faces]
    return LaidPiece(
        piece=piece,
        pose=pose,
        face=face,
        along_mm=along,
        outside_mm=outside,
        points_mm=pose.to_piece(frame.coordinates(sheet.points_in_cam_mm[index])),
        normal=normal,
        sigma_mm=scatter_of(face, along, outside, own, stripe, per_px, terms),
        by_sensor_mm=np.einsum("ni,nik->nk", out_in_cam, sheet.by_sensor[index]),
        bend_mm=(sheet.bend_mm[index] * out_in_cam).sum(axis=1),
    )


def _usual(laid: LaidPiece) -> BoolArray:
    """Tell the points that lie with the others of their side."""
    usual = np.ones(len(laid), dtype=bool)
    for index in np.unique(laid.face):
        on = np.flatnonzero(laid.face == index)
        off = laid.outside_mm[on] - np.median(laid.outside_mm[on])
        usual[on] = np.abs(off) <= _FARTHEST_SIGMAS * max(
            1.4826 * float(np.median(np.abs(off))), 1e-4
        )
    return usual
