"""What comes out over HTTP of wheels: each as measured, and those of a pass with their train."""

from datetime import datetime
from typing import Any, Self

from station.api.answers import Out
from station.api.train_answers import TrainModel
from station.operations import PassWheels
from station.store import AxleWheel, JsonObject, Measurement, PassState


class MeasurementModel(Out):
    """One wheel as measured: by what, from what, with what result."""

    id: int
    recording: str
    frame: int
    sensor: str
    pass_id: str | None
    calibration: str
    rig_calibration: str | None
    """The rig's, of a wheel that several sensors saw; `sensor` then names the rig."""
    reference: str
    software: str
    measured_at: datetime
    regime: str | None
    """Whose limits raised the alarms."""
    wheel: dict[str, Any]
    """A row of `wheels` of results.json; its profile where it was asked for."""

    @classmethod
    def of(
        cls,
        row: Measurement,
        axle: AxleWheel | None = None,
        profile: JsonObject | None = None,
    ) -> Self:
        return cls(
            id=row.id,
            recording=row.recording_id,
            frame=row.frame,
            sensor=row.sensor,
            pass_id=row.pass_id,
            calibration=row.calibration_id,
            rig_calibration=row.rig_calibration_id,
            reference=row.reference,
            software=row.software,
            measured_at=row.measured_at,
            regime=row.regime,
            wheel=row.wheel | _place_of(axle) | _profile(profile),
        )


def _profile(profile: JsonObject | None) -> JsonObject:
    return {} if profile is None else {"profile": profile}


def _place_of(axle: AxleWheel | None) -> JsonObject:
    if axle is None:
        return {}
    names = {"side": axle.side, "placing": axle.placing, "wheelset": axle.wheelset}
    return {"axle": axle.number, **names}


class WheelsModel(TrainModel):
    """The wheels of a pass; complete once its state is done or recovered."""

    pass_id: str
    state: PassState
    wheels: list[MeasurementModel]

    @classmethod
    def of(cls, found: PassWheels) -> Self:
        train = TrainModel.model_validate(found.train)
        return cls(
            **{name: getattr(train, name) for name in TrainModel.model_fields},
            pass_id=found.row.id,
            state=found.row.state,
            wheels=[MeasurementModel.of(each, found.places.get(each.id)) for each in found.wheels],
        )


class MeasurementsPage(Out):
    """Some measurements; `next` is the `after` of the next page, absent on the last."""

    measurements: list[MeasurementModel]
    next: int | None
