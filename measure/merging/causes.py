"""What may move the points of each sensor: the same causes, in the same order, for all of them."""

from collections.abc import Sequence

import numpy as np

from calib import FloatArray, Rig
from measure.gauging.uncertainty import Motions, root_of
from measure.laying.by_axle import Laid
from measure.mounting import Survey
from measure.placing.template import Template

# How much of the correction for the bend of a stripe may be wrong: on rendered wheels none of it is
# left on the tip, four tenths where the face runs out into the throat, a half on a sharp worn edge.
_BEND_SHARE = 0.5
VIBRATIONS = 3
"""What one sensor vibrates: along a, along r, and about the flange tip."""


def motions_of(
    parts: Sequence[Laid], rig: Rig, survey: Survey | None, template: Template
) -> list[Motions]:
    """Return what may move the points of each sensor's part of a shot.

    Parameters
    ----------
    parts
        Of one or more sensors of the rig.
    rig
        With what is not known of sensors and poses.
    survey
        How far sensors vibrate against each other; None of a sensor by itself.
    template
        The reference they are laid on.

    Returns
    -------
    motions
        One for each part. Shared are the causes of the rig, those of the installation, and the
        correction of each sensor's bends; afresh in every shot are those of the installation and,
        of several sensors, what each vibrates along a, along r, and about the flange tip.
    """
    root = root_of(rig.covariance)
    return [_motions(parts, place, rig, root, survey, template) for place in range(len(parts))]


def _motions(
    parts: Sequence[Laid],
    place: int,
    rig: Rig,
    root: FloatArray,
    survey: Survey | None,
    template: Template,
) -> Motions:
    part = parts[place]
    section = part.section
    by_rig = motion_by_rig(part) @ root[rig.columns(part.sensor.name)]
    bends = np.zeros((len(part.along_mm), 2, len(rig.sensors)))
    of_sensor = rig.names.index(part.sensor.name)
    bend = section.jacobian @ part.sheet.bend_mm[:, :, None] * _BEND_SHARE
    bends[:, :, of_sensor] = bend[:, :, 0]
    once = [part.once_mm]
    if survey is not None and len(parts) > 1:
        once.append(_vibrations(parts, place, survey, template))
    return Motions(
        own_mm=section.own_mm * (part.noise.counting_mm / section.sigma_mm)[:, None],
        once_mm=np.concatenate(once, axis=2),
        shared_mm=np.concatenate([by_rig, part.shared_mm, bends], axis=2),
    )


def motion_by_rig(part: Laid) -> FloatArray:
    """Return the motion of (a, r) by the parameters of its sensor in a rig, shape (N, 2, 19)."""
    section, sheet = part.section, part.sheet
    rotation = part.sensor.rig_from_camera.rotation
    by_place = section.jacobian @ rotation.T
    # The motion w x q along a row of the Jacobian is w (q x row).
    from_camera = sheet.points_in_cam_mm @ rotation.T
    by_turn = np.cross(from_camera[:, None, :], by_place)
    return np.concatenate([section.jacobian @ sheet.by_sensor, by_turn, by_place], axis=2)


def _vibrations(
    parts: Sequence[Laid], place: int, survey: Survey, template: Template
) -> FloatArray:
    """Return what the vibration of each sensor does to the points of one, (N, 2, 3 sensors).

    Its own moves them; that of any moves the axle which all share.
    """
    part = parts[place]
    motions = np.zeros((len(part.along_mm), 2, VIBRATIONS * len(parts)))
    for cause, other in enumerate(parts):
        along_r = VIBRATIONS * cause + 1
        motions[:, :, along_r] = part.by_vibration_mm.get(other.sensor.name, 0.0)
    motions[:, :, VIBRATIONS * place :][:, :, :VIBRATIONS] += _rigid(part, survey, template)
    return motions


def _rigid(part: Laid, survey: Survey, template: Template) -> FloatArray:
    """Return motions by what one sensor vibrates; two of them differ by the survey's sigmas."""
    y, z = (part.section.points_mm - part.shift_mm - template.points_mm[template.tip]).T
    one, none = np.ones_like(y), np.zeros_like(y)
    shift, turn = survey.sigma_vibration_mm, survey.sigma_vibration_rad
    along_a, along_r = np.stack([one, none], axis=1), np.stack([none, one], axis=1)
    about = np.stack([-z, y], axis=1)
    moves = [shift * along_a, shift * along_r, turn * about]
    return np.asarray(np.stack(moves, axis=2) / np.sqrt(2.0))
