"""The desks of the demo station: its own operations, by a clock that is set, before films."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from itertools import count

from demo_station_capture import Exposure, FilmedCapture
from demo_station_pictures import Pictures
from demo_station_truth import BOARD_SIGMA_MM, BOARDS, INNER, OUTER, RIG, SENSORS
from demo_station_worker import Clock, WorkerHere

from calib import Picture
from station.operations import (
    CalibrationOrder,
    DataLayout,
    MethodName,
    Passes,
    RigCalibrationOrder,
    SessionOrder,
    Sessions,
    Station,
    activate_calibration,
    activate_rig_calibration,
    order_calibration,
    order_rig_calibration,
    salvage_recording,
)
from station.settings import StationSettings
from station.store import Activation, Actor, RigActivation, Store, active, active_rig, migrate
from station.trains import Consist

CONTROLLER = Actor("controller 1", "10.20.0.7")
_SAME_AXLE_NS, _NEXT_AXLE_NS = 19_000_000, 500_000_000
Shot = Mapping[str, Picture | None]
"""What each sensor takes when the wheel sensor triggers; None is a frame that gets lost."""


@dataclass
class Desk:
    """A station in this process whose cameras are films."""

    settings: StationSettings
    pictures: Pictures
    clock: Clock
    _ids: "count[int]" = field(default_factory=lambda: count(1))

    def __post_init__(self) -> None:
        layout = DataLayout.of(self.settings)
        layout.ensure()
        migrate(layout.store_url)
        self.store = Store.open(layout.store_url)
        self.films = {
            sensor.id: FilmedCapture(sensor.id, self.clock.ns) for sensor in self.settings.sensors
        }
        self.worker = WorkerHere(self.settings, self.store, layout, self.clock)
        self.station = Station(
            settings=self.settings,
            store=self.store,
            layout=layout,
            captures=self.films,
            jobs=self.worker,
            salvage=salvage_recording,
            now=self.clock,
            new_id=lambda: f"demo{next(self._ids):06d}",
        )
        self.passes, self.sessions = Passes(self.station), Sessions(self.station)

    def train(
        self,
        pass_id: str,
        axles: Sequence[Sequence[Shot]],
        *,
        name: str | None,
        counted: int | None = None,
        consist: Consist | None = None,
    ) -> None:
        """Have a train pass, axle by axle, and its wheels measured."""
        self.passes.open(pass_id, train=name, by=CONTROLLER, consist=consist)
        self.clock.wait(seconds=7.0)
        for sensor, film in self.films.items():
            film.show(_film(axles, sensor, self.clock.ns()))
        triggers = sum(len(shots) for shots in axles)
        self.clock.wait(seconds=0.5 * len(axles) + 2.0)
        self.passes.finish(
            pass_id,
            axles=len(axles) if counted is None else counted,
            triggers=dict.fromkeys(self.films, triggers),
            by=CONTROLLER,
        )

    def session(
        self, name: str, shown: Mapping[str, Sequence[Picture]], *, by: Actor, finish: bool = True
    ) -> None:
        """Take a calibration session of what is shown to one sensor, or to those of the rig."""
        self.sessions.open(name, _order(shown), by=by)
        for sensor, pictures in shown.items():
            self.films[sensor].show(Exposure(picture) for picture in pictures)
        for number in range(min(len(pictures) for pictures in shown.values())):
            self.sessions.take_picture(name, name=f"{name}-{number}", by=by)
            self.clock.wait(seconds=20.0)
        if finish:
            self.sessions.finish(name, by=by)

    def calibrate(
        self, sensor: str, session: str, *, by: Actor, method: MethodName = "joint"
    ) -> str:
        """Have a sensor calibrated from a session; return the calibration's id."""
        order = CalibrationOrder(sensor, method, session, (), None, ())
        calibration, _ = order_calibration(self.station, order, by=by)
        return calibration.id

    def calibrate_rig(self, session: str, *, by: Actor) -> str:
        """Have the rig calibrated from a session; return the calibration's id."""
        order = RigCalibrationOrder(RIG, session, {}, None, {}, False, BOARD_SIGMA_MM)
        calibration, _ = order_rig_calibration(self.station, order, by=by)
        return calibration.id

    def activate(self, sensor: str, calibration: str, *, by: Actor) -> Activation:
        """Bring a calibration into force."""
        with self.store.look() as session:
            present = active(session, sensor)
        seen = None if present is None else present.version
        self.clock.wait(minutes=4)
        return activate_calibration(self.station, sensor, calibration, seen=seen, by=by)

    def activate_rig(self, calibration: str, *, by: Actor) -> RigActivation:
        """Bring a rig's calibration into force."""
        with self.store.look() as session:
            present = active_rig(session, RIG)
        seen = None if present is None else present.version
        self.clock.wait(minutes=2)
        return activate_rig_calibration(self.station, RIG, calibration, seen=seen, by=by)


def _order(shown: Mapping[str, object]) -> SessionOrder:
    if set(shown) == {INNER, OUTER}:
        targets = {name: BOARDS[name] for name in shown}
        return SessionOrder(target=BOARDS[INNER], rig=RIG, targets=targets)
    (sensor,) = shown
    return SessionOrder(target=BOARDS[sensor], sensor=sensor)


def _film(axles: Sequence[Sequence[Shot]], sensor: str, since_ns: int) -> Iterable[Exposure]:
    for axle, shots in enumerate(axles):
        for shot, pictures in enumerate(shots):
            after_ns = axle * _NEXT_AXLE_NS + shot * _SAME_AXLE_NS
            yield Exposure(pictures[sensor], since_ns + after_ns)


def days_before(end: datetime, days: float) -> datetime:
    """Return the moment so many days before another."""
    return end - timedelta(days=days)


def shots_of(pictures: Pictures, level: int, shots: int = 1) -> list[dict[str, Picture | None]]:
    """Return what all sensors take of an axle at a stage of its wear."""
    return [{name: pictures.wheels[name][level][shot] for name in SENSORS} for shot in range(shots)]
