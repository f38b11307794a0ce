import pytest
from worker_double import a_calibration_document

from station.operations import DataLayout, utc_now
from station.settings import StationSettings
from station.store import (
    Calibration,
    CalibrationState,
    JobKind,
    Pass,
    PassState,
    Recording,
    Store,
    add_job,
    migrate,
)


class Ground:
    """A store with work in it, as the API leaves it."""

    def __init__(self, root):
        self.settings = StationSettings(
            data_dir=root,
            sensors=[
                {"id": "left", "address": "127.0.0.2"},
                {"id": "right", "address": "127.0.0.3", "side": "right"},
            ],
        )
        self.layout = DataLayout(root)
        migrate(self.layout.store_url)
        self.store = Store.open(self.layout.store_url)
        with self.store.change() as session:
            for sensor in ("left", "right"):
                session.add(self._calibration(f"of-{sensor}", sensor, CalibrationState.READY))

    def _calibration(self, calibration_id, sensor, state, target="dots:7x8:12"):
        document = a_calibration_document(sensor).model_dump_json()
        return Calibration(
            id=calibration_id,
            state=state,
            sensor=sensor,
            target=target,
            method="joint",
            recording_ids={"recordings": [], "laser_off": []},
            created_at=utc_now(),
            job_id=f"job-{calibration_id}",
            document=document if state is CalibrationState.READY else None,
        )

    def order_calibration(self, calibration_id, target="dots:7x8:12"):
        """Leave a calibration to be solved; return its job."""
        solving = CalibrationState.SOLVING
        with self.store.change() as session:
            session.add(self._calibration(calibration_id, "left", solving, target))
            job_id = f"job-{calibration_id}"
            add_job(session, job_id, JobKind.CALIBRATE, calibration_id, at=utc_now())
        return job_id

    def order_measuring(self, pass_id, *, sensors=("left", "right"), recovered=False, names=None):
        """Leave a recorded pass to be measured; return its job."""
        job_id = f"job-{pass_id}"
        with self.store.change() as session:
            row = Pass(id=pass_id, state=PassState.MEASURING, opened_at=utc_now(), job_id=job_id)
            session.add(row)
            for sensor in sensors:
                name = (names or {}).get(sensor, sensor)
                session.add(
                    Recording(
                        id=f"pass.{pass_id}.{sensor}",
                        sensor=sensor,
                        pass_id=pass_id,
                        path=f"{name}.mcap",
                        opened_at=utc_now(),
                        closed_at=utc_now(),
                        calibration_id=f"of-{sensor}",
                        recorded=4,
                        recovered=recovered,
                    )
                )
            add_job(session, job_id, JobKind.MEASURE, pass_id, at=utc_now())
        return job_id


@pytest.fixture
def ground(tmp_path):
    ground = Ground(tmp_path)
    yield ground
    ground.store.close()
