"""The points of one wheel from all sensors of a shot, on one profile."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from calib import FloatArray, IntArray, Rig
from measure.gauging.uncertainty import Learnt, Motions
from measure.laying.by_axle import Laid, Laying
from measure.merging.align import Displacement, displacement, learn
from measure.merging.causes import motions_of
from measure.merging.contradiction import without_contradictions
from measure.merging.overlap import Overlap, Strand
from measure.mounting import Survey
from measure.placing.registration import refine_shift
from measure.placing.template import Template


@dataclass(frozen=True, slots=True)
class Misplaced:
    """Sensors that cannot be of one wheel with the first, by name, and why."""

    reasons: Mapping[str, str]


@dataclass(frozen=True, slots=True, eq=False)
class Merged:
    """One profile of one wheel.

    Attributes
    ----------
    parts
        What each sensor contributes, as it was laid.
    silent
        Why other sensors contribute nothing, by name.
    points_mm
        Shape (N, 2), (a, r), in order from the flange back to the field side.
    along_mm
        Shape (N,), place along the reference.
    sigma_mm
        Shape (N,), across the profile as it counts in a mean.
    part
        Shape (N,): which of the parts each point is of.
    shift_mm
        (y, z) of the reference = (a, r) - shift.
    motions
        What may move the points.
    aside
        By how much each part but the first lay aside from it, by its sensor's name; where both see
        enough of the same.
    """

    parts: tuple[Laid, ...]
    silent: Mapping[str, str]
    points_mm: FloatArray
    along_mm: FloatArray
    sigma_mm: FloatArray
    part: IntArray
    shift_mm: FloatArray
    motions: Motions
    aside: Mapping[str, Displacement]

    @property
    def first(self) -> Laid:
        """The part that shows most of the wheel."""
        return self.parts[0]


def merge(
    laying: Laying, rig: Rig, survey: Survey | None, template: Template
) -> Merged | Misplaced:
    """Make one profile of what the sensors of a shot show.

    Parameters
    ----------
    laying
        The stripes, laid over the reference.
    rig
        With what is not known of sensors and poses.
    survey
        Of the installation; None where one sensor was laid by the flange's shape.
    template
        The reference.

    Returns
    -------
    Merged or Misplaced
        What two sensors see lies together within its noise; or the sensors whose sections lie
        farther aside than vibration and rig explain: they would move the flange's thickness, and
        have moved the axle.
    """
    if survey is None or len(laying.parts) == 1:
        return _of_one(laying, rig, survey, template)
    motions = motions_of(laying.parts, rig, survey, template)
    strands = [
        Strand(part.section.points_mm, part.noise.counting_mm, own)
        for part, own in zip(laying.parts, motions, strict=True)
    ]
    shift = laying.parts[0].shift_mm
    overlaps = _overlaps(strands, shift, template)
    aside = _aside(overlaps, laying.parts)
    misplaced = {name: one for name, one in aside.items() if not one.plausible}
    if misplaced:
        first = laying.parts[0].sensor.name
        return Misplaced({name: _why(one, first) for name, one in misplaced.items()})
    learnt = learn(overlaps, None)
    if learnt is not None:
        # Once more from where the points then are: the reference is curved.
        nearer = _overlaps([strand.without(learnt) for strand in strands], shift, template)
        learnt = learn(nearer, learnt)
    if learnt is not None:
        strands = [strand.without(learnt) for strand in strands]
        settled = [strand.settled() for strand in strands]
        true = without_contradictions(laying.parts, _overlaps(settled, shift, template))
        if true is not None:
            return merge(replace(laying, parts=true), rig, survey, template)
    return replace(_joined(laying, strands, learnt, template), aside=aside)


def _of_one(laying: Laying, rig: Rig, survey: Survey | None, template: Template) -> Merged:
    (part,) = laying.parts
    (motions,) = motions_of(laying.parts, rig, survey, template)
    return Merged(
        parts=laying.parts,
        silent=laying.silent,
        points_mm=part.section.points_mm,
        along_mm=part.along_mm,
        sigma_mm=part.noise.counting_mm,
        part=np.zeros(len(part.along_mm), dtype=np.int64),
        shift_mm=part.shift_mm,
        motions=motions,
        aside={},
    )


def _overlaps(strands: Sequence[Strand], shift_mm: FloatArray, template: Template) -> list[Overlap]:
    """Compare the first strand with each of the others."""
    return [Overlap.of(strands[0], other, shift_mm, template) for other in strands[1:]]


def _aside(overlaps: Sequence[Overlap], parts: Sequence[Laid]) -> dict[str, Displacement]:
    """Return by how much each part lies aside from the first; where that can be told."""
    found = {
        part.sensor.name: displacement(overlap)
        for part, overlap in zip(parts[1:], overlaps, strict=True)
    }
    return {name: one for name, one in found.items() if one is not None}


def _why(one: Displacement, first: str) -> str:
    lateral, radial = one.shift_mm
    return (
        f"its section lies {lateral:+.2f} mm along the axle and {radial:+.2f} mm along the radius "
        f"from that of sensor {first}, {one.sigmas:.0f} times what vibration and rig explain: "
        "check the rig on its reference piece"
    )


def _joined(
    laying: Laying, strands: Sequence[Strand], learnt: Learnt | None, template: Template
) -> Merged:
    points = np.concatenate([strand.points_mm for strand in strands])
    shift = refine_shift(points, laying.parts[0].shift_mm, template)
    along = template.place(points - shift)[0]
    order = np.argsort(along, kind="stable")
    motions = Motions.concatenated([strand.motions for strand in strands]).select(order)
    return Merged(
        parts=laying.parts,
        silent=laying.silent,
        points_mm=points[order],
        along_mm=along[order],
        sigma_mm=np.concatenate([strand.sigma_mm for strand in strands])[order],
        part=np.repeat(np.arange(len(strands)), [len(s.points_mm) for s in strands])[order],
        shift_mm=shift,
        motions=replace(motions, learnt=learnt),
        aside={},
    )
