"""What the station tells Prometheus of its calibrations."""

from collections.abc import Iterable, Iterator

from prometheus_client.core import Metric
from prometheus_client.registry import Collector
from pydantic import ValidationError
from sqlalchemy.orm import Session

from station.api.families import Values, by_sensor, gauges
from station.documents import CalibrationDocument, RigDocument
from station.operations import Station
from station.recalibration import Outcome
from station.store import Calibration, Recalibration, RigCalibration, active, active_rig, the
from station.store.recalibrations import alarm_of, asking_recalibrations, last_decided

_DIFFERENCES = (
    ("difference", "sheet_rms_mm", "RMS difference that the last recalibration found."),
    ("largest", "sheet_largest_mm", "The largest difference that it found."),
)
_PIXELS = ("dots_px", "stripe_px")


class RecalibrationCollector(Collector):
    """Reads them from the store when they are asked for, a value a sensor or rig."""

    def __init__(self, station: Station) -> None:
        self._station = station
        self._rms: dict[str, dict[str, float]] = {}
        """Of calibrations in force, by id: their documents are large, and never change."""

    def collect(self) -> Iterable[Metric]:
        with self._station.store.look() as session:
            return [
                *self._in_force(session),
                *self._rigs_in_force(session),
                *self._watched(session),
                *self._decided(session),
            ]

    def _age_s(self, row: Calibration | RigCalibration) -> float:
        return (self._station.now() - row.created_at).total_seconds()

    def _in_force(self, session: Session) -> Iterator[Metric]:
        rows = {
            sensor.id: the(session, Calibration, present.calibration_id)
            for sensor in self._station.sensors
            if (present := active(session, sensor.id)) is not None
        }
        yield gauges(
            "station_calibration_age_seconds",
            "Age of the calibration in force.",
            ["sensor"],
            by_sensor((sensor, self._age_s(row)) for sensor, row in rows.items()),
        )
        yield gauges(
            "station_calibration_rms_pixels",
            "RMS residual of the calibration in force: of its target's dots and of the stripe.",
            ["sensor", "of"],
            {
                (sensor, of): value
                for sensor, row in rows.items()
                for of, value in self._rms_of(row).items()
            },
        )

    def _rigs_in_force(self, session: Session) -> Iterator[Metric]:
        rows = {
            rig.id: the(session, RigCalibration, present.rig_calibration_id)
            for rig in self._station.settings.rigs
            if (present := active_rig(session, rig.id)) is not None
        }
        yield gauges(
            "station_rig_calibration_age_seconds",
            "Age of the rig's calibration in force.",
            ["rig"],
            by_sensor((rig, self._age_s(row)) for rig, row in rows.items()),
        )
        yield gauges(
            "station_rig_calibration_rms_pixels",
            "RMS residual of the rig's calibration in force.",
            ["rig", "of"],
            {(rig, of): v for rig, row in rows.items() for of, v in self._rms_of(row).items()},
        )

    def _rms_of(self, row: Calibration | RigCalibration) -> dict[str, float]:
        if row.id not in self._rms:
            self._rms[row.id] = _rms(row)
        return self._rms[row.id]

    def _watched(self, session: Session) -> Iterator[Metric]:
        sensors = [sensor.id for sensor in self._station.sensors]
        yield gauges(
            "station_recalibration_alarm",
            "1 where the calibration in force may measure wrongly.",
            ["sensor"],
            by_sensor((each, float(alarm_of(session, each) is not None)) for each in sensors),
        )
        yield gauges(
            "station_recalibration_asking",
            "Recalibrations that wait for a person.",
            ["sensor"],
            by_sensor((each, len(asking_recalibrations(session, each))) for each in sensors),
        )

    def _decided(self, session: Session) -> Iterator[Metric]:
        rows = {
            sensor.id: row
            for sensor in self._station.sensors
            if (row := last_decided(session, sensor.id)) is not None
        }
        now = self._station.now()
        ages = ((each, (now - (row.ended_at or row.ordered_at))) for each, row in rows.items())
        yield gauges(
            "station_recalibration_age_seconds",
            "Time since a recalibration came to a decision.",
            ["sensor"],
            by_sensor((sensor, age.total_seconds()) for sensor, age in ages),
        )
        yield gauges(
            "station_recalibration_outcome",
            "1 for what the last recalibration found.",
            ["sensor", "outcome"],
            {
                (sensor, outcome.value): float(row.outcome == outcome.value)
                for sensor, row in rows.items()
                for outcome in Outcome
            },
        )
        for name, figure, text in _DIFFERENCES:
            values = _figures_m(rows, figure)
            yield gauges(f"station_recalibration_{name}_meters", text, ["sensor"], values)


def _figures_m(rows: dict[str, Recalibration], figure_mm: str) -> Values:
    found = ((sensor, (row.figures or {}).get(figure_mm)) for sensor, row in rows.items())
    return by_sensor((sensor, None if value is None else value / 1000.0) for sensor, value in found)


def _rms(row: Calibration | RigCalibration) -> dict[str, float]:
    """Return the residuals that a calibration tells, by what they are of."""
    kind = CalibrationDocument if isinstance(row, Calibration) else RigDocument
    try:
        rms = kind.model_validate_json(row.document or "").rms
    except ValidationError:
        return {}  # of another version; the alarms beside it are told all the same
    known = {name: getattr(rms, name, None) for name in _PIXELS}
    return {name.removesuffix("_px"): value for name, value in known.items() if value is not None}
