"""From a picture of the target to its numbered points and the stripe across it."""

from dataclasses import replace

import cv2
import numpy as np

from calib.arrays import Picture
from calib.errors import TargetNotFound
from calib.seeing.noise import PixelNoise
from calib.seeing.stripe_on_board import find_board_stripes, stripes_of_board
from calib.seeing.target_corners import CornerPattern
from calib.seeing.target_dots import DotPattern
from calib.target import Target
from calib.views import View

FEWEST_SEEN = 0.5
"""Share of the target's points that must be seen."""


def observe_target(
    picture: Picture,
    target: Target,
    *,
    name: str,
    laser_off: Picture | None = None,
    points_in: Picture | None = None,
) -> View:
    """Find the target's points and the stripe in one picture.

    Parameters
    ----------
    picture
        Shape (H, W), 8 bit.
    target
        What is looked for. Its rows run down the picture, within 45 degrees, where its shape
        leaves a choice; it is seen from the front.
    name
        The picture's name, for the view and for messages.
    laser_off
        The same scene with the laser off: the points are then taken from it, and the stripe
        from the difference.
    points_in
        With `laser_off`: a third picture of the scene, exposed for the points, that they are taken
        from instead.

    Returns
    -------
    View
        Points and stripe with their sigmas; some points may be missing. `stripe` is None where
        no line crosses the board; where several do, the likeliest, and the others in `rivals`.

    Raises
    ------
    TargetNotFound
        If fewer than half of the points are seen, or their numbering is not certain.
    ValueError
        If a picture is not 8 bit of shape (H, W), two differ in shape, or `points_in` is given
        without `laser_off`.
    """
    if points_in is not None and laser_off is None:
        raise ValueError("points_in needs laser_off: where the two differ the stripe is")
    for each in (picture, laser_off, points_in):
        if each is None:
            continue
        if each.ndim != 2 or each.dtype != np.uint8 or each.shape != picture.shape:
            raise ValueError(
                "pictures must be 8 bit of one shape (H, W), got "
                f"{each.dtype} of shape {each.shape} beside {picture.shape}"
            )
    dark = picture if laser_off is None else laser_off
    scene = dark if points_in is None else points_in
    noise = PixelNoise.from_picture(scene)
    pattern: DotPattern | CornerPattern | None
    if target.kind == "dots":
        pattern = DotPattern.find(scene, noise, target)
    else:
        pattern = CornerPattern.find(scene, noise, target)
    if pattern is None:
        raise TargetNotFound(_refusal(name, target, "no pattern of points is seen"))
    if laser_off is None:
        area = pattern.area(target)
        stripes = find_board_stripes(pattern.without_marks(picture), noise, area)
        cleared = pattern.cleared(picture, noise, target, stripes)
        if cleared is not None:
            area = replace(area, cleared=True)
            stripes = find_board_stripes(cleared, noise, area)
        seen = pattern.numbered(scene, noise, target, stripes.lines)
    else:
        lit = np.asarray(cv2.subtract(picture, laser_off), dtype=np.uint8)
        of_dark = noise if points_in is None else PixelNoise.from_picture(dark)
        both = PixelNoise(2.0 * of_dark.floor, of_dark.gain)
        area = pattern.area(target)
        stripes = find_board_stripes(lit, both, area)
        seen = pattern.numbered(scene, noise, target, [])
    if seen is None:
        seen_text = f"{len(pattern)} points are seen, and it is not certain which they are"
        raise TargetNotFound(_refusal(name, target, seen_text))
    if len(seen) < FEWEST_SEEN * target.rows * target.cols:
        raise TargetNotFound(_refusal(name, target, f"{len(seen)} points are seen"))
    seen_area = replace(seen.area(target), cleared=area.cleared)
    candidates = stripes_of_board(stripes, seen_area)
    likeliest = candidates[0] if candidates else None
    return View(name, seen.sorted_points(), likeliest, tuple(candidates[1:]), seen.dot_radius)


def _refusal(name: str, target: Target, seen: str) -> str:
    least = int(np.ceil(FEWEST_SEEN * target.rows * target.cols))
    return (
        f"{name}: {seen}; {target} needs {least} of its {target.rows * target.cols} points, "
        "all borders among them: show all of the target, or check TARGET"
    )
