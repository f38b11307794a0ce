"""What comes out over HTTP of the station as a whole."""

from station.api.answers import Out
from station.api.health_answers import StationAlarmModel


class SensorModel(Out):
    """A sensor and how it is."""

    id: str
    side: str
    address: str
    state: str
    """What its capture process says, or `unreachable`."""
    problem: str | None
    active_calibration: str | None
    alarm: str | None
    """Why its calibration may measure wrongly, as its last recalibration found."""
    asks: str | None
    """The recalibration that waits for a person."""


class RigModel(Out):
    """Sensors that look at the same wheel."""

    id: str
    side: str
    sensors: list[str]
    anchor: str
    """The sensor whose mounting places it."""
    active_calibration: str | None


class StationModel(Out):
    """The station and how it is."""

    name: str
    software: str
    reference: str
    sensors: list[SensorModel]
    rigs: list[RigModel]
    pass_in_progress: str | None
    worker_ready: bool
    disk_free_bytes: int
    disk_total_bytes: int
    alarms: list[StationAlarmModel]
    """What somebody should look at, the gravest first."""
