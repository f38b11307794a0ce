"""From profile files to results: the readings of a contact instrument's points."""

from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

from measure import Limits, MiniProfText, ReferenceProfile, gauge_profile
from station.documents import HeaderDocument, MeasurementDocument, WheelDocument, wheel_document
from station.errors import InputUnusable
from station.pipeline.naming import distinct_names
from station.pipeline.references import load_reference, read_profile
from station.software import SOFTWARE


def gauge_files(
    paths: Sequence[Path],
    *,
    reference: str = "S1002",
    limits: Limits | None = None,
    assume_back: bool = False,
) -> MeasurementDocument:
    """Read the gauges off profile files, a wheel each; one that is no whole wheel has a reason.

    Raises
    ------
    InputUnusable
        If a file or the reference cannot be used.
    """
    if not paths:
        raise InputUnusable("no PROFILE given; give MiniProf files or CSV of d,h")
    new = load_reference(reference)
    limits = limits if limits is not None else Limits.default()
    names = distinct_names(paths)
    return MeasurementDocument(
        created=datetime.now(UTC),
        software=SOFTWARE,
        calibration=None,
        reference=new.name,
        regime=limits.regime,
        wheels=tuple(
            _wheel(name, read_profile(path), new, limits, assume_back=assume_back)
            for name, path in zip(names, paths, strict=True)
        ),
    )


def _wheel(
    name: str, file: MiniProfText, new: ReferenceProfile, limits: Limits, *, assume_back: bool
) -> WheelDocument:
    answer = gauge_profile(file.profile, new, limits, levels=file.levels, assume_back=assume_back)
    return wheel_document(
        answer,
        source=name,
        sensor="",
        reference=new,
        header=_header(file) if file.header else None,
    )


def _header(file: MiniProfText) -> HeaderDocument:
    levels = file.levels
    return HeaderDocument(
        claimed=dict(file.claimed),
        levels_mm={"L1": levels.below_tip_mm, "L2": levels.tape_d_mm, "L3": levels.face_mm},
        fields=dict(file.header),
    )
