"""Measuring what a rig recorded once more, after one of its sensors was recalibrated.

A rig's wheel is measured from all of its sensors: the others go in as they were.
"""

from station.documents import CalibrationDocument, RigDocument
from station.errors import NothingMeasurable
from station.progress import Progress
from station.store import (
    Calibration,
    Measurement,
    Pass,
    Recording,
    RigCalibration,
    recordings_of,
    the,
)
from station.worker.context import WorkContext
from station.worker.rows import RecordedOnRig, rows_on_rig


def measure_on_rig_again(
    context: WorkContext, own: Recording, new: Calibration, progress: Progress
) -> list[Measurement]:
    """Return the wheels of a pass as its rig sees them with a sensor's new calibration.

    They are kept beside the recording of that sensor, whose calibration is what is new: with the
    recording that a wheel's frame is of, a wheel could not be told from what it was before.

    Parameters
    ----------
    own
        The sensor's recording.
    new
        Its calibration.

    Raises
    ------
    NothingMeasurable
        If what another sensor of the rig recorded has made way: without it the wheels would be
        others, not the same ones measured again.
    """
    rows = rows_on_rig(context, _recorded(context, own, new), progress)
    for place, row in enumerate(rows):
        if row.recording_id != own.id:
            # Its frame is of another recording, where the number may be another wheel's; no camera
            # gives a negative one, and what was measured is told by the wheel itself.
            row.recording_id, row.frame = own.id, -1 - place
        row.calibration_id = new.id
    return rows


def _recorded(context: WorkContext, own: Recording, new: Calibration) -> RecordedOnRig:
    with context.store.look() as session:
        rig = the(session, RigCalibration, own.rig_calibration_id or "")
        together = [
            each
            for each in recordings_of(session, the(session, Pass, own.pass_id or ""))
            if each.rig_calibration_id == own.rig_calibration_id
        ]
        gone = [each.sensor for each in together if each.deleted_at is not None]
        if gone:
            raise NothingMeasurable(
                f"what sensor {gone[0]} recorded has been deleted; the rig's wheels cannot be "
                "measured again without it"
            )
        calibrations = [
            new if each.id == own.id else the(session, Calibration, each.calibration_id)
            for each in together
            if each.calibration_id is not None
        ]
    return RecordedOnRig(
        RigDocument.model_validate_json(rig.document or ""),
        tuple(together),
        tuple(
            CalibrationDocument.model_validate_json(each.document or "") for each in calibrations
        ),
    )
