"""What the station tells Prometheus of its calibrations."""

from collections.abc import Iterable

from prometheus_client.core import GaugeMetricFamily, Metric
from prometheus_client.registry import Collector
from sqlalchemy.orm import Session

from station.operations import Station
from station.store import Calibration, active, alarm_of, asking_recalibrations, last_decided, the

_FAMILIES = {
    "station_calibration_age_seconds": "Age of the calibration in force.",
    "station_recalibration_alarm": "1 where the calibration in force may measure wrongly.",
    "station_recalibration_asking": "Recalibrations that wait for a person.",
    "station_recalibration_age_seconds": "Time since a recalibration came to a decision.",
    "station_recalibration_difference_mm": "RMS difference that the last recalibration found.",
    "station_recalibration_largest_mm": "The largest difference that it found.",
}


class RecalibrationCollector(Collector):
    """Reads them from the store when they are asked for, a value a sensor."""

    def __init__(self, station: Station) -> None:
        self._station = station

    def collect(self) -> Iterable[Metric]:
        with self._station.store.look() as session:
            values = {
                sensor.id: self._values(session, sensor.id) for sensor in self._station.sensors
            }
        for name, text in _FAMILIES.items():
            family = GaugeMetricFamily(name, text, labels=["sensor"])
            for sensor, told in values.items():
                if name in told:
                    family.add_metric([sensor], told[name])
            yield family

    def _values(self, session: Session, sensor: str) -> dict[str, float]:
        now = self._station.now()
        told = {
            "station_recalibration_alarm": float(alarm_of(session, sensor) is not None),
            "station_recalibration_asking": float(len(asking_recalibrations(session, sensor))),
        }
        present, last = active(session, sensor), last_decided(session, sensor)
        if present is not None:
            made = the(session, Calibration, present.calibration_id).created_at
            told["station_calibration_age_seconds"] = (now - made).total_seconds()
        if last is not None:
            ended = last.ended_at or last.ordered_at
            told["station_recalibration_age_seconds"] = (now - ended).total_seconds()
            for name, figure in (("difference", "sheet_rms_mm"), ("largest", "sheet_largest_mm")):
                if figure in (last.figures or {}):
                    told[f"station_recalibration_{name}_mm"] = (last.figures or {})[figure]
        return told
