"""From measurements of new wheels to the reference that wear is counted from."""

import re
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path

from measure import (
    REFERENCE_STEP_MM,
    REFERENCE_WINDOW_MM,
    MeasureError,
    NewWheel,
    Reading,
    gauge_profile,
    reference_of_new_wheels,
    reference_profile,
)
from station.documents import (
    REFERENCE_NAME,
    MeasuredWheel,
    MeasurementDocument,
    ReadingDocument,
    ReferenceDocument,
    WheelDocument,
    reference_nominal,
    reference_points,
)
from station.errors import InputUnusable
from station.pipeline.calibrate import sha256_of
from station.pipeline.references import ANALYTIC, is_json, read_profile
from station.software import SOFTWARE

Found = tuple[NewWheel, MeasuredWheel]


def register_reference(paths: Sequence[Path], name: str) -> ReferenceDocument:
    """Make a reference of every measured wheel in results and profile files.

    Raises
    ------
    InputUnusable
        If a file cannot be used, a name is taken, or the wheels make no reference.
    """
    if name in ANALYTIC:
        raise InputUnusable(f"--name {name} is that of a drawing; give a name of your own")
    if not re.fullmatch(REFERENCE_NAME, name):
        raise InputUnusable(
            f"--name {name!r}; allowed: up to 64 letters, digits, blanks, dots, - and _"
        )
    found = [each for path in paths for each in _wheels_in(path)]
    try:
        measured = reference_of_new_wheels([wheel for wheel, _ in found])
        measured.profile(name)
    except MeasureError as error:
        raise InputUnusable(f"no reference can be made: {error}") from error
    return ReferenceDocument(
        name=name,
        created=datetime.now(UTC),
        software=SOFTWARE,
        nominal=reference_nominal(measured),
        profile=reference_points(measured),
        made_of=tuple(origin for _, origin in found),
        options={"step_mm": REFERENCE_STEP_MM, "window_mm": REFERENCE_WINDOW_MM},
    )


def _wheels_in(path: Path) -> Iterator[Found]:
    if is_json(path):
        yield from _wheels_of_results(path)
        return
    file = read_profile(path)
    answer = gauge_profile(file.profile, reference_profile("S1002"))
    if answer.reason is not None:
        raise InputUnusable(f"{path}: {answer.reason}; a reference needs a whole wheel")
    wheel = NewWheel(file.profile, answer.readings)
    yield wheel, _origin(path, file.header.get("WheelID") or path.stem, None)


def _wheels_of_results(path: Path) -> Iterator[Found]:
    document = MeasurementDocument.read(path)
    if not document.measured:
        raise InputUnusable(f"{path}: none of its {len(document.wheels)} wheels was measured")
    for wheel in document.wheels:
        if wheel.profile is not None:
            readings = {quantity: _reading(each) for quantity, each in wheel.readings.items()}
            new = NewWheel(wheel.profile.profile(), readings)
            yield new, _origin(path, _called(wheel), document.calibration)


def _reading(said: ReadingDocument) -> Reading:
    return Reading(said.value, said.u95, said.status, said.alarm)


def _called(wheel: WheelDocument) -> str:
    return wheel.source if wheel.frame is None else f"{wheel.source} frame {wheel.frame}"


def _origin(path: Path, wheel: str, calibration: str | None) -> MeasuredWheel:
    return MeasuredWheel(
        name=path.name, sha256=sha256_of(path), wheel=wheel, calibration=calibration
    )
