"""What a rig is made of, however it is calibrated: its calibrations, its anchor, its side."""

from collections import Counter
from collections.abc import Sequence

from calib import Rig
from measure import Side
from station.documents import CalibrationDocument, SurveyDocument
from station.errors import InputUnusable


def ensure_rig(calibrations: Sequence[CalibrationDocument], anchor: str | None) -> None:
    """Refuse calibrations that make no rig, and an anchor that is none of its sensors.

    Raises
    ------
    InputUnusable
        If they do not.
    """
    names = [each.sensor for each in calibrations]
    counted = Counter(names)
    if len(names) < 2 or max(counted.values()) > 1:
        raise InputUnusable(
            f"the calibrations are of {', '.join(names) or 'no sensor'}; "
            "allowed: two or more sensors, one calibration of each"
        )
    if anchor is not None and anchor not in names:
        raise InputUnusable(f"anchor {anchor}; allowed: {', '.join(names)}")


def anchoring_of(
    calibrations: Sequence[CalibrationDocument], anchor: str | None
) -> CalibrationDocument:
    """Return the calibration of the anchor: the first with a mounting where none is wished."""
    known = [each for each in calibrations if each.mounting is not None]
    wanted = anchor or next(iter([*known, *calibrations])).sensor
    return next(each for each in calibrations if each.sensor == wanted)


def side_of(anchoring: CalibrationDocument) -> Side:
    """Return the side of the train that the anchor stands on, as the settings take it."""
    mounting = anchoring.mounting
    # Mirrored ones stand at x below 0.
    mirrored = mounting is not None and mounting.translation_mm[0] < 0.0
    return Side.RIGHT if mirrored else Side.LEFT


def surveyed(
    rig: Rig,
    anchoring: CalibrationDocument,
    *,
    sigma_vibration_mm: float | None,
    sigma_vibration_rad: float | None,
) -> tuple[Rig, SurveyDocument | None]:
    """Return a rig, solved in its anchor's camera, where the anchor's survey puts it.

    Without a survey it stays as it is; the survey is then None.
    """
    mounting = anchoring.mounting
    if mounting is None:
        return rig, None
    survey = SurveyDocument.of_mounting(
        mounting,
        sigma_vibration_mm=sigma_vibration_mm,
        sigma_vibration_rad=sigma_vibration_rad,
    )
    return rig.moved(mounting.rig_from_camera()), survey
