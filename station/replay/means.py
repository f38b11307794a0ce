"""What recordings are measured with, as something that travels to other machines."""

import hashlib
import pickle
import tempfile
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path

from measure import Limits, Side
from station.documents import CalibrationDocument, MeasurementDocument, RigDocument
from station.errors import InputUnusable
from station.pipeline import RigGauge, WheelGauge
from station.replay.passes import Lookers
from station.software import SOFTWARE


@dataclass(frozen=True, slots=True, eq=False)
class Means:
    """Calibrations, rigs, reference and limits of one replay.

    Raises
    ------
    InputUnusable
        If there is neither calibration nor rig, two calibrations are of one sensor, or two rigs
        share one.
    """

    calibrations: tuple[CalibrationDocument, ...]
    rigs: tuple[RigDocument, ...]
    reference: str
    """A name, or the path of a file."""
    limits: Limits
    sides: Mapping[str, Side]
    max_skew_us: Mapping[str, float]
    """Greatest time between frames of one shot, of single rigs."""
    reference_file: bytes | None = None
    """What is in that file: another machine does not have it."""

    def __post_init__(self) -> None:
        if not (self.calibrations or self.rigs):
            raise InputUnusable(
                "nothing to measure with; give --calibration of the sensor, or --rig"
            )
        if len({one.sensor for one in self.calibrations}) < len(self.calibrations):
            raise InputUnusable("two calibrations of one sensor; give one of each sensor")
        in_rigs = [name for rig in self.rigs for name in rig.names]
        if len(set(in_rigs)) < len(in_rigs):
            raise InputUnusable("two rigs have a sensor in common; give one rig of each sensor")

    @classmethod
    def of(
        cls,
        calibrations: Sequence[CalibrationDocument],
        *,
        rigs: Sequence[RigDocument] = (),
        reference: str = "S1002",
        limits: Limits | None = None,
        sides: Mapping[str, Side] | None = None,
        max_skew_us: Mapping[str, float] | None = None,
    ) -> "Means":
        """Make them of what a measurement takes; a reference in a file is read."""
        file = Path(reference)
        return cls(
            calibrations=tuple(calibrations),
            rigs=tuple(rigs),
            reference=reference,
            limits=limits if limits is not None else Limits.default(),
            sides=dict(sides or {}),
            max_skew_us=dict(max_skew_us or {}),
            reference_file=file.read_bytes() if file.is_file() else None,
        )

    @property
    def by_pass(self) -> bool:
        """Whether the recordings of a pass are measured together, axle for axle."""
        return bool(self.rigs) or len(self.calibrations) > 1

    @property
    def sensors(self) -> tuple[str, ...]:
        """All sensors, those of rigs behind the others."""
        in_rigs = [name for rig in self.rigs for name in rig.names]
        alone = [one.sensor for one in self.calibrations if one.sensor not in in_rigs]
        return (*alone, *in_rigs)

    @property
    def fingerprint(self) -> str:
        """SHA-256 over all that readings depend on but the recordings and the software."""
        found = hashlib.sha256()
        for part in (
            *sorted(one.fingerprint for one in self.calibrations),
            *sorted(one.fingerprint for one in self.rigs),
            self.reference if self.reference_file is None else repr(self.reference_file),
            repr(self.limits),
            repr(sorted((sensor, side.value) for sensor, side in self.sides.items())),
            repr(sorted(self.max_skew_us.items())),
        ):
            found.update(part.encode() + b"\0")
        return found.hexdigest()

    def packed(self) -> bytes:
        """Return it as bytes for `unpacked`."""
        return zlib.compress(pickle.dumps(self))

    def lookers(self) -> Lookers:
        """Return what looks at the train.

        Raises
        ------
        InputUnusable
            If the reference is neither known nor a profile's file, or a rig cannot measure wheels.
        """
        by_sensor = {one.sensor: one for one in self.calibrations}
        in_rigs = {name for rig in self.rigs for name in rig.names}
        return Lookers(
            gauges={
                sensor: WheelGauge.of(one, self.reference, self.limits)
                for sensor, one in by_sensor.items()
                if sensor not in in_rigs
            },
            rigs={
                rig.rig: RigGauge.of(
                    rig,
                    self.reference,
                    self.limits,
                    calibrations=[by_sensor[name] for name in rig.names if name in by_sensor],
                )
                for rig in self.rigs
            },
            sides={**self.sides, **{rig.rig: rig.side for rig in self.rigs}},
        )

    def heading(self, lookers: Lookers) -> MeasurementDocument:
        """Return what a table says of all its wheels."""
        prints = {name: known for rig in self.rigs for name, known in rig.calibrations.items()}
        prints |= {one.sensor: one.fingerprint for one in self.calibrations}
        alone = len(prints) == 1
        gauge = lookers.first
        return MeasurementDocument(
            created=datetime.now(UTC),
            software=SOFTWARE,
            calibration=next(iter(prints.values())) if alone else None,
            calibrations={} if alone else prints,
            rigs={rig.rig: rig.fingerprint for rig in self.rigs},
            reference=gauge.reference.name,
            regime=gauge.limits.regime,
            wheels=(),
        )


@lru_cache(maxsize=4)
def unpacked(packed: bytes) -> tuple[Means, Lookers]:
    """Return means that came from another process, and what looks at the train with them."""
    means: Means = pickle.loads(zlib.decompress(packed))
    if means.reference_file is None:
        return means, means.lookers()
    # The reference is called as its file is: it is put into one of the same name.
    with tempfile.TemporaryDirectory(prefix="treadline-reference-") as folder:
        copy = Path(folder, Path(means.reference).name)
        copy.write_bytes(means.reference_file)
        return means, replace(means, reference=str(copy)).lookers()
