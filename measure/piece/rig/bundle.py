"""One piece in several placings, and sensors whose places to each other are not known yet."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib import FloatArray, LaserSensor, RigidTransform
from measure.piece.certified import Piece
from measure.piece.match import GATE_MM
from measure.piece.rig.contact import stepped, touch
from measure.piece.rig.laying import Fit, points_fit
from measure.piece.rig.prisms import Known, Placing, fit_prisms
from measure.piece.rig.sighting import Sighting, first_placing, given_sides, with_length_along

START_MM = 20.0
"""How far sensors may stand from where the search for them starts: what a tape tells, ..."""
START_RAD = 0.05
"""... and a level."""
_SLANT_RAD = 0.26
"""A piece shown to calibrate a rig may be slanted; beyond this it is not found."""
_FIRST_SLANT_RAD = 0.03
LEAST_SPREAD_RAD = 0.05
"""Slants that differ by less are told by nothing but noise."""
# Cost a point, of points that count alike: nothing but noise is left.
_CLEAR = 4.0
_FLIPS = 3
_BETTER = 0.9
_REMATCHES = 2
# A wrong shot, between whose pictures the piece was moved, fits worse than the others by this.
_WRONG_FACTOR = 2.0
_WRONG_MM = 0.01
_FEWEST_PLACINGS = 2


@dataclass(frozen=True, slots=True, eq=False)
class Shown:
    """One placing of the piece by all sensors that saw it: name, and what each showed."""

    name: str
    sightings: tuple[Sighting, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Bundle:
    """All placings that fit together.

    Attributes
    ----------
    names, placings, fits
        For each placing: its name, its points and pose, and the points as they were measured.
    cameras
        rig_from_camera of all sensors.
    left_out
        Reason by name of each shot that is not in it.
    """

    names: tuple[str, ...]
    placings: tuple[Placing, ...]
    fits: tuple[tuple[Fit, ...], ...]
    cameras: tuple[RigidTransform, ...]
    left_out: Mapping[str, str]

    def flattened(self, piece: Piece) -> "Bundle":
        """Return the bundle as if slants too small to be told were none.

        How long a cut is changes with the square of a slant, and noise makes a slant of any piece:
        about a small one the slope of that square would tell what it does not.
        """
        square = self.placings[0].square_to
        lengths = np.stack([one.rig_from_piece.rotation[:, 1] for one in self.placings])
        lengths *= np.sign(lengths @ square)[:, None]
        across = np.linalg.svd(square[None])[2][1:]
        off = lengths @ across.T
        middle = off.mean(axis=0)
        spread, axes = np.linalg.eigh((off - middle).T @ (off - middle) / len(off))
        for variance, axis in zip(spread, axes.T, strict=True):
            if variance < LEAST_SPREAD_RAD**2:
                kept = middle @ axis if abs(middle @ axis) > LEAST_SPREAD_RAD else 0.0
                off = off + np.outer(kept - off @ axis, axis)
        flat = square + off @ across
        flat /= np.linalg.norm(flat, axis=1)[:, None]
        return replace(
            self,
            placings=tuple(
                replace(one, rig_from_piece=with_length_along(one.rig_from_piece, length, piece))
                for one, length in zip(self.placings, flat, strict=True)
            ),
        )

    def rms_mm(self, piece: Piece) -> FloatArray:
        """Root mean square distance of the points from the piece, a placing, shape (M,)."""
        return np.array([_rms_mm(one, self.cameras, piece) for one in self.placings])


def bundle_placings(
    shown: Sequence[Shown],
    sensors: Sequence[LaserSensor],
    start: Sequence[RigidTransform],
    piece: Piece,
    *,
    free: Sequence[int],
    known: Known,
) -> Bundle:
    """Fit all placings and the free sensors together, and leave out what does not belong.

    Parameters
    ----------
    shown
        Placings that two sensors or more saw.
    sensors, start
        In the order of the rig; where they are thought to stand.
    piece
        As large as it is now.
    free
        Sensors whose poses are sought.
    known
        What is known of these poses.
    """
    cameras, left_out = list(start), {}
    placings, cameras = _first_fit(shown, sensors, cameras, piece, free)
    placings, cameras = _on_the_better_side(placings, cameras, piece, free)
    for _ in range(_REMATCHES):
        placings = [
            _rematched(one, of_shot.sightings, cameras, piece)
            for one, of_shot in zip(placings, shown, strict=True)
        ]
        placings, cameras, _ = fit_prisms(placings, cameras, piece, free=free, known=known)
    kept: list[tuple[str, Placing, tuple[Fit, ...]]] = []
    for one, of_shot in zip(placings, shown, strict=True):
        fits = [
            points_fit(each, sensors[each.sensor], cameras, one, piece)
            for each in of_shot.sightings
        ]
        usable = tuple(fit for fit in fits if isinstance(fit, Fit))
        if len(usable) < 2:
            left_out[of_shot.name] = next(fit for fit in fits if isinstance(fit, str))
            continue
        contacts = tuple(fit.contact for fit in usable)
        kept.append((of_shot.name, replace(one, contacts=contacts), usable))
    return _without_wrong(kept, cameras, piece, free, known, left_out)


def _first_fit(
    shown: Sequence[Shown],
    sensors: Sequence[LaserSensor],
    start: Sequence[RigidTransform],
    piece: Piece,
    free: Sequence[int],
) -> tuple[list[Placing], list[RigidTransform]]:
    # Square to the sheet the slope of the cost by the slant is zero: start beside it.
    beside = np.array([0.0, 0.0, 0.0, _FIRST_SLANT_RAD, _FIRST_SLANT_RAD])
    placings = []
    for of_shot in shown:
        one = first_placing(of_shot.sightings, sensors, start, piece)
        placings.append(
            replace(
                one,
                rig_from_piece=stepped(one.rig_from_piece, beside, piece),
                slant_sigma_rad=float(np.hypot(one.slant_sigma_rad, _SLANT_RAD)),
            )
        )
    roughly = Known.within(start, START_MM, START_RAD)
    ways = []
    # With the start held, how sections shift against each other tells slants of sheets that stand
    # apart; of sheets that lie together their cuts do. What fits in the end was the right way.
    for first in (roughly.but_within_section(placings[0].square_to), roughly):
        led, cameras, _ = fit_prisms(placings, start, piece, free=free, known=first)
        ways.append(fit_prisms(led, cameras, piece, free=free, known=roughly))
        if ways[-1][2] < _CLEAR * sum(len(each.face) for one in led for each in one.contacts):
            break
    best = min(ways, key=lambda way: way[2])
    return best[0], best[1]


def _on_the_better_side(
    placings: Sequence[Placing],
    start: Sequence[RigidTransform],
    piece: Piece,
    free: Sequence[int],
) -> tuple[list[Placing], list[RigidTransform]]:
    """Lean single placings to the other side where that fits better.

    How long a cut is tells how far a piece is slanted, but not to which side: that is told by
    the sheets' places to each other, and these by the other placings.
    """
    now, cameras = list(placings), list(start)
    for _ in range(_FLIPS):
        flipped = [_flipped(one, cameras, piece) for one in now]
        if all(after is before for after, before in zip(flipped, now, strict=True)):
            break
        now, cameras, _ = fit_prisms(
            flipped, cameras, piece, free=free, known=Known.within(cameras, START_MM, START_RAD)
        )
    return now, cameras


def _flipped(placing: Placing, cameras: Sequence[RigidTransform], piece: Piece) -> Placing:
    """Return the placing, slanted to another side where that fits better by a clear share."""
    (alone,), _, cost = fit_prisms([placing], cameras, piece)
    if cost < _CLEAR * sum(len(each.face) for each in alone.contacts):
        return placing
    about_x, about_z = placing.slant_rad
    best, least = placing, _BETTER * cost
    for by_x, by_z in ((-2.0, 0.0), (0.0, -2.0), (-2.0, -2.0)):
        step = np.array([0.0, 0.0, 0.0, by_x * about_x, by_z * about_z])
        tried = replace(placing, rig_from_piece=stepped(placing.rig_from_piece, step, piece))
        (tried,), _, cost = fit_prisms([tried], cameras, piece)
        if cost < least:
            best, least = tried, cost
    return best


def _rematched(
    placing: Placing,
    sightings: Sequence[Sighting],
    cameras: Sequence[RigidTransform],
    piece: Piece,
) -> Placing:
    piece_from_rig = placing.rig_from_piece.inverse()
    contacts = [
        given_sides(one, piece_from_rig @ cameras[one.sensor], piece, GATE_MM) for one in sightings
    ]
    return replace(placing, contacts=tuple(contacts))


def _without_wrong(
    kept: Sequence[tuple[str, Placing, tuple[Fit, ...]]],
    start: Sequence[RigidTransform],
    piece: Piece,
    free: Sequence[int],
    known: Known,
    left_out: dict[str, str],
) -> Bundle:
    """Fit, and leave out shot after shot that fits worse by far than the others."""
    now, cameras = list(kept), list(start)
    while now:
        placings, cameras, _ = fit_prisms(
            [one for _, one, _ in now], cameras, piece, free=free, known=known
        )
        now = [(name, one, fits) for (name, _, fits), one in zip(now, placings, strict=True)]
        rms = np.array([_rms_mm(one, cameras, piece) for one in placings])
        worst, usual = int(np.argmax(rms)), float(np.median(rms))
        if len(now) <= _FEWEST_PLACINGS or rms[worst] <= max(
            _WRONG_FACTOR * usual, usual + _WRONG_MM
        ):
            break
        left_out[now[worst][0]] = (
            f"its points lie {rms[worst]:.3f} mm off the piece, others {usual:.3f}; was it moved "
            "between the pictures?"
        )
        del now[worst]
    return Bundle(
        tuple(name for name, _, _ in now),
        tuple(one for _, one, _ in now),
        tuple(fits for _, _, fits in now),
        tuple(cameras),
        left_out,
    )


def _rms_mm(placing: Placing, cameras: Sequence[RigidTransform], piece: Piece) -> float:
    off = [
        touch(one, cameras[one.sensor], placing.rig_from_piece, piece).outside_mm
        for one in placing.contacts
    ]
    return float(np.sqrt(np.mean(np.concatenate(off) ** 2)))
