"""Points of several sensors laid on one piece that all of them see at the same time."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib import FloatArray, IntArray, LaserSensor, Rig, RigidTransform, StripePoints
from measure.laying.section import SheetPoints
from measure.piece.certified import Piece
from measure.piece.kept import inside, unbent
from measure.piece.laid import LaidPoints, usual
from measure.piece.match import GATE_MM, MIN_POINTS, gate_mm, matched
from measure.piece.noise import scatter_of
from measure.piece.rig.contact import Contact, Touch, section_of, touch
from measure.piece.rig.prisms import Placing, fit_prisms
from measure.piece.rig.sighting import Sighting, first_placing, given_sides, sight

_REMATCHES = 3


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """The points of one sensor that are fit to be measured, in order along the profile.

    Attributes
    ----------
    sheet
        The points, N of them.
    contact
        The same, on their sides; their weights are one over what scatters them.
    along_mm
        Shape (N,), place along its side.
    """

    sheet: SheetPoints
    contact: Contact
    along_mm: FloatArray


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class LaidOnRig(LaidPoints):
    """The points of all sensors on one piece, sensor by sensor.

    Attributes
    ----------
    sensor
        Shape (N,), the place in the rig of the one that saw it.
    rig_from_piece
        Where the piece lies; its y is the middle of the points.
    """

    sensor: IntArray
    rig_from_piece: RigidTransform


def lay_on_rig(
    shot: Mapping[str, StripePoints], rig: Rig, piece: Piece
) -> tuple[LaidOnRig | None, dict[str, str]]:
    """Lay what the sensors of a rig saw at one time on a piece.

    Parameters
    ----------
    shot
        All ridges of each sensor's picture.
    rig
        The rig under test.
    piece
        As large as it is now.

    Returns
    -------
    laid
        The points of all sensors that saw the piece; None if none did.
    reasons
        For each sensor of the shot that did not, why.
    """
    sighted = {
        name: sight(stripe, rig.names.index(name), rig[name].sensor, piece)
        for name, stripe in shot.items()
    }
    sightings = [one for one in sighted.values() if isinstance(one, Sighting)]
    reasons = {name: one for name, one in sighted.items() if isinstance(one, str)}
    if not sightings:
        return None, reasons
    cameras = [each.rig_from_camera for each in rig.sensors]
    sensors = [each.sensor for each in rig.sensors]
    placing = settled_placing(
        first_placing(sightings, sensors, cameras, piece), sightings, cameras, piece
    )
    fits: list[Fit] = []
    for sighting in sightings:
        fit = points_fit(sighting, sensors[sighting.sensor], cameras, placing, piece)
        if isinstance(fit, str):
            reasons[rig.names[sighting.sensor]] = fit
        else:
            fits.append(fit)
    if not fits:
        return None, reasons
    placing = replace(placing, contacts=tuple(fit.contact for fit in fits))
    (placing,), _, _ = fit_prisms([placing], cameras, piece)
    return _laid(placing, fits, rig, piece), reasons


def settled_placing(
    placing: Placing,
    sightings: Sequence[Sighting],
    cameras: Sequence[RigidTransform],
    piece: Piece,
) -> Placing:
    """Refine a placing, its points given their sides afresh as it settles."""
    for _ in range(_REMATCHES):
        (placing,), _, _ = fit_prisms([placing], cameras, piece)
        contacts = [
            given_sides(one, placing.rig_from_piece.inverse() @ cameras[one.sensor], piece, GATE_MM)
            for one in sightings
        ]
        placing = replace(placing, contacts=tuple(contacts))
    return placing


def points_fit(
    sighting: Sighting,
    sensor: LaserSensor,
    cameras: Sequence[RigidTransform],
    placing: Placing,
    piece: Piece,
) -> Fit | str:
    """Return the points of one sensor that are fit to be measured, or why there are too few."""
    piece_from_camera = placing.rig_from_piece.inverse() @ cameras[sighting.sensor]
    sheet = sighting.sheet
    section, along, normal = section_of(sheet, piece_from_camera)
    match = matched(section, normal, piece, gate_mm(piece, GATE_MM))
    kept = inside(match, sheet, np.linalg.norm(along, axis=1), piece)
    if len(kept) < MIN_POINTS:
        return (
            f"{len(kept)} points on the piece away from its edges; {MIN_POINTS} are needed: "
            "show more of it, or a larger one"
        )
    sheet = unbent(sheet.select(kept), match.face[kept], sensor, piece)
    section, _, normal = section_of(sheet, piece_from_camera)
    match = matched(section, normal, piece, np.inf)
    order = np.lexsort((match.along_mm, match.face))
    order = order[match.face[order] >= 0]
    alike = usual(match.face[order], match.outside_mm[order])
    if alike.sum() < MIN_POINTS:
        return f"{alike.sum()} points agree with each other; {MIN_POINTS} are needed"
    order = order[alike]
    sheet, face, place = sheet.select(order), match.face[order], match.along_mm[order]
    _, along, _ = section_of(sheet, piece_from_camera)
    out_in_cam = match.normal[order] @ piece_from_camera.rotation[[0, 2]]
    own = np.abs((sheet.across_mm * out_in_cam).sum(axis=1))
    per_px = np.linalg.norm(along, axis=1)
    sigma = scatter_of(face, place, match.outside_mm[order], own, sheet.stripe, per_px, piece.terms)
    contact = Contact(sighting.sensor, sheet.points_in_cam_mm, face, 1.0 / sigma)
    return Fit(sheet, contact, place)


def _laid(placing: Placing, fits: Sequence[Fit], rig: Rig, piece: Piece) -> LaidOnRig:
    """Describe the points of all sensors: where they lie, and what may move them."""
    cameras = [rig.sensors[fit.contact.sensor].rig_from_camera for fit in fits]
    lies = [
        touch(fit.contact, camera, placing.rig_from_piece, piece)
        for fit, camera in zip(fits, cameras, strict=True)
    ]
    out_in_cam = [
        lie.normal_in_rig @ camera.rotation for lie, camera in zip(lies, cameras, strict=True)
    ]
    seen = list(zip(fits, lies, out_in_cam, strict=True))
    length = np.concatenate([lie.length_mm for lie in lies])
    middle = np.array([0.0, float(length.mean()), 0.0])
    return LaidOnRig(
        piece=piece,
        sensor=np.concatenate([np.full(len(fit.along_mm), fit.contact.sensor) for fit in fits]),
        rig_from_piece=placing.rig_from_piece @ RigidTransform(np.eye(3), middle),
        face=np.concatenate([fit.contact.face for fit in fits]),
        along_mm=np.concatenate([fit.along_mm for fit in fits]),
        outside_mm=np.concatenate([lie.outside_mm for lie in lies]),
        points_mm=np.concatenate([lie.section_mm for lie in lies]),
        normal=np.concatenate([lie.normal for lie in lies]),
        length_mm=length - middle[1],
        sigma_mm=np.concatenate([1.0 / fit.contact.weight for fit in fits]),
        by_sensor_mm=np.concatenate([_by_rig(*each, rig) for each in seen]),
        bend_mm=np.concatenate([(fit.sheet.bend_mm * out).sum(axis=1) for fit, _, out in seen]),
        slant_rad=placing.slant_rad,
        slant_sigma_rad=placing.slant_sigma_rad,
    )


def _by_rig(fit: Fit, lie: Touch, out_in_cam: FloatArray, rig: Rig) -> FloatArray:
    """Return the points' motion out of the metal by all parameters of the rig, (N, 19 K)."""
    motion = np.zeros((len(out_in_cam), len(rig.covariance)))
    motion[:, rig.columns(rig.names[fit.contact.sensor])] = np.column_stack([
        np.einsum("ni,nik->nk", out_in_cam, fit.sheet.by_sensor),
        lie.by_rig,
    ])
    return motion
