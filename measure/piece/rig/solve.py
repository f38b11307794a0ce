"""Where the sensors of a rig stand to each other, from one piece that all of them see at once."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from calib import Degenerate, LaserSensor, RigidTransform, StripePoints
from measure.piece.certified import Piece
from measure.piece.rig.bundle import START_MM, START_RAD, Shown, bundle_placings
from measure.piece.rig.doubt import doubt_of
from measure.piece.rig.found import Found, RigFromPiece
from measure.piece.rig.laying import Fit
from measure.piece.rig.prisms import Known
from measure.piece.rig.sighting import Sighting, sight


def rig_from_piece(
    shots: Sequence[tuple[str, Mapping[str, StripePoints]]],
    sensors: Mapping[str, LaserSensor],
    piece: Piece,
    *,
    anchor: str,
    start: Mapping[str, RigidTransform],
    sigma_start_mm: float | None = None,
    sigma_start_rad: float | None = None,
    temperature_c: float | None = None,
) -> RigFromPiece:
    r"""Find where sensors stand to each other from pictures of one piece in several placings.

    Parameters
    ----------
    shots
        Name of each placing, and all ridge points of each sensor's picture. The piece stands
        still while the pictures of one shot are taken.
    sensors
        By name, in the order of the rig, with their covariances.
    piece
        As certified at 20 degrees C: long enough to be in all sheets.
    anchor
        The sensor whose camera gives the frame.
    start
        rig_from_camera of each, in any one frame: to a few centimetres and degrees.
    sigma_start_mm, sigma_start_rad
        How well a survey knows each sensor's place against the anchor, along each axis, and its
        turn about each. None: not at all, it is where the search starts; only both together fill
        what the placings leave open.
    temperature_c
        Of the piece; None counts its warmth as unknown.

    Returns
    -------
    RigFromPiece
        The rig, with the joint covariance of all.

    Raises
    ------
    Degenerate
        If a sensor was never on the piece together with another one, or if a motion of it is not
        told by the placings and no survey tells it.
    ValueError
        If the names do not agree, or a sigma is not positive.

    Notes
    -----
    A prism is the same all along its length. In one placing it tells three of the six motions of
    a sensor, those within its section; where its length points elsewhere it tells others. Hence:

    - placings whose lengths are parallel leave the shift along the length open;
    - where the piece stands square to a sheet its cut does not change with a slant, to first
      order: tilts are told by slanted placings, and the slants themselves too;
    - the mirror image of a rig in the sheet of its anchor shows the same sections: where the
      sheets lie nearly in one plane, the start must tell one from the other.

    The sensors are held as they were calibrated: a section tells few of their thirteen parameters.
    What they are off by moves the poses, :math:`p = p_0 + G (s - s_0)`, and stands in the
    covariance with its cross terms, :math:`C_{ps} = G C_s`.
    """
    names = tuple(sensors)
    _ensure_named(names, anchor, start, shots)
    # What a holder keeps is of the rig's frame, which is not known yet.
    now = replace(piece.warmed(temperature_c), length_in_rig=None)
    to_anchor = start[anchor].inverse()
    first = [
        RigidTransform.identity() if name == anchor else to_anchor @ start[name] for name in names
    ]
    known = _known(first, sigma_start_mm, sigma_start_rad)
    base = names.index(anchor)
    free = [index for index in range(len(names)) if index != base]
    calibrated = [sensors[name] for name in names]
    shown, left_out = _shown(shots, names, calibrated, now)
    _ensure_joined([_seen_by(shot) for shot in shown], names, base, left_out)
    bundle = bundle_placings(shown, calibrated, first, now, free=free, known=known)
    left_out |= bundle.left_out
    _ensure_joined([_measured_by(fits) for fits in bundle.fits], names, base, left_out)
    stretch = now.stretch_u95(temperature_c)
    doubt = doubt_of(
        bundle.flattened(now), calibrated, now, free=free, known=known, stretch_u95=stretch
    )
    surveyed = None not in (sigma_start_mm, sigma_start_rad)
    found = Found(names, base, free, first, calibrated, bundle, doubt, now, surveyed)
    found.ensure_told()
    return found.answer(left_out)


def _seen_by(shot: Shown) -> set[int]:
    return {one.sensor for one in shot.sightings}


def _measured_by(fits: Sequence[Fit]) -> set[int]:
    return {fit.contact.sensor for fit in fits}


def _ensure_named(
    names: tuple[str, ...],
    anchor: str,
    start: Mapping[str, RigidTransform],
    shots: Sequence[tuple[str, Mapping[str, StripePoints]]],
) -> None:
    if len(names) < 2:
        raise ValueError(f"sensors are {', '.join(names) or 'none'}; a rig has two or more")
    if anchor not in names:
        raise ValueError(f"the anchor is {anchor}; allowed: one of {', '.join(names)}")
    missing = [name for name in names if name not in start]
    if missing:
        raise ValueError(f"no start for {missing[0]}; give rig_from_camera of each sensor")
    strange = [name for _, shot in shots for name in shot if name not in names]
    if strange:
        raise ValueError(f"a shot names {strange[0]}; allowed: {', '.join(names)}")


def _known(
    first: Sequence[RigidTransform], sigma_mm: float | None, sigma_rad: float | None
) -> Known:
    for name, sigma in (("sigma_start_mm", sigma_mm), ("sigma_start_rad", sigma_rad)):
        if sigma is not None and not 0.0 < sigma < float("inf"):
            raise ValueError(f"{name} must be positive, got {sigma!r}")
    return Known.within(first, sigma_mm or START_MM, sigma_rad or START_RAD)


def _shown(
    shots: Sequence[tuple[str, Mapping[str, StripePoints]]],
    names: Sequence[str],
    sensors: Sequence[LaserSensor],
    piece: Piece,
) -> tuple[list[Shown], dict[str, str]]:
    """Return the shots in which two sensors or more see the piece, and why others are not."""
    shown: list[Shown] = []
    left_out: dict[str, str] = {}
    for name, shot in shots:
        seen = {
            each: sight(stripe, names.index(each), sensors[names.index(each)], piece)
            for each, stripe in shot.items()
        }
        sightings = [one for one in seen.values() if isinstance(one, Sighting)]
        if len(sightings) >= 2:
            shown.append(Shown(name, tuple(sightings)))
            continue
        reasons = [f"{each}: {one}" for each, one in seen.items() if isinstance(one, str)]
        reasons += [f"{each}: no picture" for each in names if each not in shot]
        left_out[name] = "; ".join(reasons)
    return shown, left_out


def _ensure_joined(
    groups: Sequence[set[int]], names: Sequence[str], base: int, left_out: Mapping[str, str]
) -> None:
    """Refuse sensors that no chain of shots, each given by who saw it, joins to the anchor."""
    reached, before = {base}, set[int]()
    while reached != before:
        before = set(reached)
        for group in groups:
            if group & reached:
                reached |= group
    lonely = [name for index, name in enumerate(names) if index not in reached]
    if lonely:
        why = next((f"; {shot}: {reason}" for shot, reason in left_out.items()), "")
        raise Degenerate(
            f"{lonely[0]} was in no shot on the piece together with {names[base]}{why}; hold the "
            "piece where all sheets meet it"
        )
