"""Recalibrating without a running station: here and now, under the worker's lock."""

from collections.abc import Callable, Sequence

from station.errors import InputUnusable
from station.operations import DataLayout, add_recalibration
from station.pipeline import calibrate_rig_sources, calibrate_sources, measure_rig, measure_sources
from station.processes.lock import held
from station.settings import StationSettings
from station.store import Actor, Recalibration, Store, active, migrate, the
from station.store.recalibrations import running_recalibration
from station.worker.context import Mathematics, WorkContext
from station.worker.recalibrating import recalibrate

_BY = Actor("station recalibrate")


def recalibrate_here(
    settings: StationSettings,
    sensor: str | None,
    *,
    new_id: Callable[[], str],
    say: Callable[[str], None],
) -> Sequence[Recalibration]:
    """Recalibrate a sensor, or all that have a calibration in force; return what came of it.

    One that a killed worker left is gone on with.

    Raises
    ------
    InputUnusable
        If no sensor has a calibration in force.
    StateConflict
        If a worker runs on this data folder.
    """
    layout = DataLayout.of(settings)
    layout.ensure()
    with held(layout.worker_lock, "a worker"):
        migrate(layout.store_url)
        store = Store.open(layout.store_url)
        mathematics = Mathematics(
            calibrate_sources, measure_sources, calibrate_rig_sources, measure_rig
        )
        context = WorkContext(settings, store, layout, mathematics)
        rows = []
        for name in sensors_to_do(context, sensor):
            say(f"recalibrating {name}")
            rows.append(_recalibrate(context, name, new_id))
        store.close()
    return rows


def sensors_to_do(context: WorkContext, sensor: str | None) -> list[str]:
    """Return the sensor, or all that have a calibration in force.

    Raises
    ------
    InputUnusable
        If none has one.
    """
    if sensor is not None:
        return [sensor]
    with context.store.look() as session:
        known = [
            each.id for each in context.settings.sensors if active(session, each.id) is not None
        ]
    if not known:
        raise InputUnusable(
            "no sensor has a calibration in force; calibrate and activate one, or give --sensor ID"
        )
    return known


def _recalibrate(context: WorkContext, sensor: str, new_id: Callable[[], str]) -> Recalibration:
    with context.store.change() as session:
        row = running_recalibration(session, sensor)
        if row is None:
            row, _ = add_recalibration(session, new_id(), sensor=sensor, by=_BY, at=context.now())
    recalibrate(context, row.job_id)
    with context.store.look() as session:
        return the(session, Recalibration, row.id)
