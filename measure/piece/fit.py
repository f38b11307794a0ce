"""Points of a stripe laid on a piece: rigidly, robustly, and not beside its edges."""

from dataclasses import dataclass

import numpy as np

from calib import FloatArray, IntArray, LaserSensor, SheetFrame, StripePoints
from measure.laying.section import SheetPoints
from measure.piece.certified import Piece
from measure.piece.kept import inside, unbent
from measure.piece.laid import LaidPoints, usual
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


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class LaidPiece(LaidPoints):
    """The points of one picture, in one section of the piece.

    Attributes
    ----------
    pose
        Where the piece lies on the sheet.
    """

    pose: PiecePose


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
    sheet = hanging_together(stripe, sensor)
    if isinstance(sheet, str):
        return sheet
    found = poses_on_sheet(sheet, sensor, piece)
    if not found:
        return f"no piece: nothing in the picture has the profile of {piece.name}"
    return _laid(found[0][0], sheet, sensor, SheetFrame.of(sensor.plane), piece)


def hanging_together(stripe: StripePoints, sensor: LaserSensor) -> SheetPoints | str:
    """Return the points that hang together, on the sheet, or why there are too few."""
    hanging = stripe.select(sizes(pieces(stripe.centre_px, stripe.normal)) >= MIN_PIECE)
    sheet = SheetPoints.of(hanging, sensor)
    if len(sheet) < MIN_POINTS:
        return f"no stripe: {len(sheet)} points hang together, {MIN_POINTS} are needed"
    return sheet


def poses_on_sheet(
    sheet: SheetPoints, sensor: LaserSensor, piece: Piece
) -> list[tuple[PiecePose, float]]:
    """Return the poses in which a piece may lie, and the length of profile each explains.

    The best is first; none where nothing in the picture has the profile of the piece.
    """
    place, normal = _on_sheet(sheet, SheetFrame.of(sensor.plane))
    fits = [settled(pose, place, normal, piece) for pose in find_piece(place, normal, piece)]
    explained = [explained_mm(fit, place, normal, piece) for fit in fits]
    return sorted(zip(fits, explained, strict=True), key=lambda one: -one[1])


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
    kept = inside(match, sheet, _mm_per_px(sheet, frame), piece)
    if len(kept) < MIN_POINTS:
        return (
            f"{len(kept)} points on the piece away from its edges; {MIN_POINTS} are needed: "
            "show more of it, or a larger one"
        )
    sheet = unbent(sheet.select(kept), match.face[kept], sensor, piece)
    place, normal = _on_sheet(sheet, frame)
    pose = settled(pose, place, normal, piece)
    match = matched(pose.to_piece(place), normal @ pose.turn, piece, np.inf)
    order = np.lexsort((match.along_mm, match.face))
    order = order[match.face[order] >= 0]
    alike = usual(match.face[order], match.outside_mm[order])
    if alike.sum() < MIN_POINTS:
        return f"{alike.sum()} points agree with each other; {MIN_POINTS} are needed"
    return _measured(pose, match, order[alike], sheet, frame, piece)


def _mm_per_px(sheet: SheetPoints, frame: SheetFrame) -> FloatArray:
    return np.asarray(np.linalg.norm(sheet.along_mm @ frame.axes_in_cam.T, axis=1))


def _measured(
    pose: PiecePose,
    match: Match,
    index: IntArray,
    sheet: SheetPoints,
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
    per_px = _mm_per_px(sheet, frame)[index]
    return LaidPiece(
        piece=piece,
        pose=pose,
        face=face,
        along_mm=along,
        outside_mm=outside,
        points_mm=pose.to_piece(frame.coordinates(sheet.points_in_cam_mm[index])),
        normal=normal,
        length_mm=np.zeros(len(index)),
        sigma_mm=scatter_of(face, along, outside, own, stripe, per_px, piece.terms),
        by_sensor_mm=np.einsum("ni,nik->nk", out_in_cam, sheet.by_sensor[index]),
        bend_mm=(sheet.bend_mm[index] * out_in_cam).sum(axis=1),
        slant_rad=np.zeros(2),
        slant_sigma_rad=piece.squareness_rad,
    )
