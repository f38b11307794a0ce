"""The rig that a piece showed: its covariance, what of it is told, and what is left open."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from calib import (
    RIG_PARAMETERS,
    SENSOR_PARAMETERS,
    Degenerate,
    FloatArray,
    LaserSensor,
    Rig,
    RigidTransform,
    RigSensor,
)
from measure.piece.certified import Piece
from measure.piece.rig.bundle import Bundle
from measure.piece.rig.doubt import Doubt, Workplace, mirrored, scaled_inverse

OPEN_MM = 0.5
"""What the points leave more doubtful than this, at the piece, they do not tell."""
_MIDDLING_MM = 0.05
_MOTIONS = (
    "a shift along the piece's x",
    "a shift along the piece's length",
    "a shift along the piece's z",
    "a tilt about the piece's x",
    "a twist about the piece's length",
    "a tilt about the piece's z",
)
_IN_SECTION = (_MOTIONS[0], _MOTIONS[2], _MOTIONS[4])
_CURE = (
    "show the piece in four placings or more, its length slanted by 10 degrees to different sides "
    "and about both axes, or tell how well a survey knows the sensors' places"
)


@dataclass(frozen=True, slots=True)
class RigMotion:
    """How well one motion of a sensor against the anchor is known, where it looks at the piece.

    Attributes
    ----------
    sensor, name
        Whose, and which motion.
    sigma_mm
        In all: points, sensors, certificate, survey. Of turns at half the piece's size.
    told_mm
        By the points alone; infinite where these say nothing and the survey must.
    """

    sensor: str
    name: str
    sigma_mm: float
    told_mm: float

    @property
    def in_section(self) -> bool:
        """Whether it is one of the three that move what is seen within the piece's section."""
        return self.name in _IN_SECTION


@dataclass(frozen=True, slots=True, eq=False)
class RigFromPiece:
    """A rig as a piece showed it.

    Attributes
    ----------
    rig
        In the frame of the anchor's camera, whose pose has no variance. Its sensors are those
        given, as they were calibrated.
    rms_mm
        Distance of the points from the piece, by shot.
    left_out
        Reason by shot that was not used.
    motions
        How well each motion of each sensor is known.
    warnings
        What is poorly told, or left to the survey.
    """

    rig: Rig
    rms_mm: Mapping[str, float]
    left_out: Mapping[str, str]
    motions: tuple[RigMotion, ...]
    warnings: tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """A bundle with its doubt: what the rig is made of.

    Attributes
    ----------
    names, base, free
        The sensors, which of them is the anchor, and which are not.
    first, sensors
        Where the search started, and what they are.
    bundle, doubt, piece
        What was found on what.
    surveyed
        Whether what is known of the start may fill what the piece leaves open.
    """

    names: tuple[str, ...]
    base: int
    free: Sequence[int]
    first: Sequence[RigidTransform]
    sensors: Sequence[LaserSensor]
    bundle: Bundle
    doubt: Doubt
    piece: Piece
    surveyed: bool

    @property
    def places(self) -> list[Workplace]:
        """Where the free sensors look at the piece."""
        return [Workplace.of(self.bundle, index, self.piece) for index in self.free]

    @property
    def of_sensors(self) -> FloatArray:
        """Covariance of all sensors' own parameters, shape (13 K, 13 K)."""
        return _block_diagonal([each.covariance for each in self.sensors])

    def motions(self, covariance: FloatArray) -> tuple[RigMotion, ...]:
        """Return how well each motion is known, with a covariance of the poses."""
        names = [self.names[index] for index in self.free]
        return _motions(self.doubt, covariance, self.places, names)

    def ensure_told(self) -> None:
        """Refuse what neither the placings nor a survey tell.

        Raises
        ------
        Degenerate
            If a motion is open.
        """
        for one in self.motions(self.doubt.covariance(self.of_sensors)):
            if one.told_mm == float("inf") and not self.surveyed:
                raise Degenerate(
                    f"{one.name} of {one.sensor} is not told by these placings; {_CURE}"
                )

    def answer(self, left_out: Mapping[str, str]) -> RigFromPiece:
        """Return the rig, its mirror image counted as doubt where nothing excludes it."""
        twins = [self._twin(*each) for each in zip(self.free, self.places, strict=True)]
        apart = np.concatenate([step for step, _ in twins])
        covariance = self.doubt.covariance(self.of_sensors) + np.outer(apart, apart)
        motions = self.motions(covariance)
        placed = zip(self.names, self.sensors, self.bundle.cameras, strict=True)
        rig = Rig(
            tuple(RigSensor(name, sensor, pose) for name, sensor, pose in placed),
            _rig_covariance(
                covariance,
                self.doubt.by_sensors @ self.of_sensors,
                self.of_sensors,
                self.free,
                len(self.names),
            ),
        )
        rms = zip(self.bundle.names, self.bundle.rms_mm(self.piece).tolist(), strict=True)
        warnings = (*(said for _, said in twins if said), *_warnings(motions))
        return RigFromPiece(rig, dict(rms), dict(left_out), motions, warnings)

    def _twin(self, index: int, place: Workplace) -> tuple[FloatArray, str]:
        """Return the step to the mirror image where the start does not exclude it, else none."""
        planes = [each.plane for each in self.sensors]
        found, first = self.bundle.cameras[index], self.first[index]
        twin = mirrored(self.bundle.cameras, planes, index, self.base)
        step = _step(found, twin)
        away, found_off, twin_off = (
            float(np.linalg.norm(place.from_step @ one))
            for one in (step, _step(first, found), _step(first, twin))
        )
        if twin_off > 2.0 * found_off or away < 0.1 * OPEN_MM:
            return np.zeros(6), ""
        message = (
            f"{self.names[index]} and its mirror image in the sheet of {self.names[self.base]} fit "
            f"alike; they are {away:.2f} mm apart, and the start is {found_off:.2f} and "
            f"{twin_off:.2f} mm off them"
        )
        if away > OPEN_MM and not self.surveyed:
            raise Degenerate(f"{message}; tell better where the sensors stand, or use boards")
        return step, f"{message}: counted as doubt"


def _step(before: RigidTransform, after: RigidTransform) -> FloatArray:
    turn = RigidTransform(after.rotation @ before.rotation.T, np.zeros(3)).rotation_vector
    return np.concatenate([turn, after.translation_mm - before.translation_mm])


def _motions(
    doubt: Doubt, covariance: FloatArray, places: Sequence[Workplace], names: Sequence[str]
) -> tuple[RigMotion, ...]:
    motions = []
    told = _told_covariance(doubt.information, places)
    for at, (place, name) in enumerate(zip(places, names, strict=True)):
        here = slice(6 * at, 6 * at + 6)
        there = place.from_step @ covariance[here, here] @ place.from_step.T
        sigmas, by_points = np.sqrt(np.diag(there)), np.sqrt(np.diag(told[here, here]))
        for motion, sigma, alone in zip(_MOTIONS, sigmas, by_points, strict=True):
            clear = float(alone) if alone <= OPEN_MM else float("inf")
            motions.append(RigMotion(name, motion, float(sigma), clear))
    return tuple(motions)


def _told_covariance(information: FloatArray, places: Sequence[Workplace]) -> FloatArray:
    """Return the covariance of the motions by the points alone; where these say nothing, vast."""
    back = _block_diagonal([np.asarray(np.linalg.inv(place.from_step)) for place in places])
    there = back.T @ information @ back
    return scaled_inverse(there + 1e-6 * np.eye(len(there)))


def _warnings(motions: Sequence[RigMotion]) -> list[str]:
    """Return what is poorly told, or left to the survey."""
    warnings = []
    for one in motions:
        which = f"{one.name} of {one.sensor}"
        if one.told_mm == float("inf"):
            warnings.append(
                f"{which} is left to the survey, {one.sigma_mm:.3f} mm: the placings do not tell it"
            )
        elif one.sigma_mm > _MIDDLING_MM:
            warnings.append(f"{which} is known to {one.sigma_mm:.3f} mm only")
    return warnings


def _rig_covariance(
    poses: FloatArray, cross: FloatArray, of_sensors: FloatArray, free: Sequence[int], count: int
) -> FloatArray:
    """Return the covariance in the order of `calib.Rig`; the anchor's pose has none."""
    size, own = len(RIG_PARAMETERS), len(SENSOR_PARAMETERS)
    parameters = np.arange(size * count)
    of_own = parameters[parameters % size < own]
    of_poses = np.concatenate([parameters[size * k + own : size * (k + 1)] for k in free])
    covariance = np.zeros((size * count, size * count))
    covariance[np.ix_(of_own, of_own)] = of_sensors
    covariance[np.ix_(of_poses, of_poses)] = 0.5 * (poses + poses.T)
    covariance[np.ix_(of_poses, of_own)] = cross
    covariance[np.ix_(of_own, of_poses)] = cross.T
    return covariance


def _block_diagonal(blocks: Sequence[FloatArray]) -> FloatArray:
    size = sum(len(block) for block in blocks)
    whole, at = np.zeros((size, size)), 0
    for block in blocks:
        whole[at : at + len(block), at : at + len(block)] = block
        at += len(block)
    return whole
