import pytest
from newest_schema import make_store
from worker_double import a_calibration_document, a_rig_document

from station.operations import DataLayout, utc_now
from station.operations.collaborators import Station
from station.pipeline import gauge, rig_gauge
from station.settings import StationSettings
from station.store import (
    Calibration,
    CalibrationState,
    JobKind,
    Pass,
    PassState,
    Recording,
    RigCalibration,
    Store,
    add_job,
    the,
)


class Ground:
    """A store with work in it, as the API leaves it."""

    def __init__(self, root):
        self.settings = StationSettings(
            data_dir=root,
            sensors=[
                {"id": "left", "address": "127.0.0.2"},
                {"id": "right", "address": "127.0.0.3", "side": "right"},
                {"id": "inner", "address": "127.0.0.4"},
                {"id": "outer", "address": "127.0.0.5"},
            ],
            rigs=[{"id": "wheel", "sensors": ["inner", "outer"], "anchor": "outer"}],
        )
        self.layout = DataLayout(root)
        make_store(self.layout.store_url)
        self.store = Store.open(self.layout.store_url)
        with self.store.change() as session:
            for sensor in ("left", "right", "inner", "outer"):
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

    def bring_rig_into_force(self, calibration_id="of-wheel"):
        document = a_rig_document("wheel", ["inner", "outer"])
        with self.store.change() as session:
            session.add(
                RigCalibration(
                    id=calibration_id,
                    state=CalibrationState.READY,
                    rig="wheel",
                    created_at=utc_now(),
                    document=document.model_dump_json(),
                )
            )
        return calibration_id

    def take_off_rig(self, pass_id, sensor):
        """Have a sensor recorded by itself, as one that is in no rig."""
        with self.store.change() as session:
            the(session, Recording, f"pass.{pass_id}.{sensor}").rig_calibration_id = None

    def order_rig_calibration(self, calibration_id):
        """Leave a rig to be calibrated; return its job."""
        job_id = f"job-{calibration_id}"
        ordered = {
            "recordings": {},
            "calibrations": {"inner": "of-inner", "outer": "of-outer"},
            "targets": {"inner": "dots:7x8:12", "outer": "dots:7x8:12"},
            "same_board": False,
            "board_sigma_mm": 0.02,
        }
        with self.store.change() as session:
            session.add(
                RigCalibration(
                    id=calibration_id,
                    state=CalibrationState.SOLVING,
                    rig="wheel",
                    ordered=ordered,
                    created_at=utc_now(),
                    job_id=job_id,
                )
            )
            add_job(session, job_id, JobKind.CALIBRATE_RIG, calibration_id, at=utc_now())
        return job_id

    def order_measuring(
        self,
        pass_id,
        *,
        sensors=("left", "right"),
        recovered=False,
        names=None,
        rig=None,
        recorded=None,
    ):
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
                        rig_calibration_id=rig,
                        recorded=(recorded or {}).get(sensor, 4),
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


class _Deaf:
    """An engine that is told of jobs and does none: the tests do the steps."""

    def submit(self, _kind, _job_id): ...

    def cancel(self, _job_id): ...


@pytest.fixture
def station(ground):
    return Station(ground.settings, ground.store, ground.layout, {}, _Deaf(), lambda _: None)


@pytest.fixture
def located(monkeypatch):
    """Count how often a stripe is looked for."""
    count = []
    for module in (gauge, rig_gauge):
        locate = module.locate_wheel_stripe
        monkeypatch.setattr(
            module, "locate_wheel_stripe", lambda p, found=locate: count.append(1) or found(p)
        )
    return count
