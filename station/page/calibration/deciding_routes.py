"""Bringing a calibration into force or refusing it, and answering recalibrations that ask."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Literal

from fastapi import APIRouter, Form, Request, Response

from station.api import By, Calibrator, IdInPath, PartsOf, Reader
from station.operations import (
    activate_calibration,
    activate_rig_calibration,
    answer_recalibration,
    refuse_calibration,
    refuse_rig_calibration,
)
from station.page.going import go_to
from station.page.shell import ShellOf
from station.store import Calibration, Recalibration, RigCalibration, Store, the

router = APIRouter()
Version = Annotated[int, Form(ge=0, le=2**31 - 1)]
"""Of what was in force when the person looked; 0 where nothing was."""
Why = Annotated[str, Form(min_length=1, max_length=500)]


@dataclass(frozen=True, slots=True)
class Decidable:
    """A kind of calibration that a person decides on.

    Attributes
    ----------
    address
        Its reports are below that.
    of
        Returns whose a calibration is, by its id: the name of a sensor, or a rig.
    activate, refuse
        The operations.
    """

    address: str
    of: Callable[[Store, str], str]
    activate: Callable[..., object]
    refuse: Callable[..., object]

    def routes(self) -> APIRouter:
        """Return the two routes of its decisions."""
        routes = APIRouter(prefix=f"{self.address}/{{calibration_id}}")

        @routes.post("/activate")
        def post_activate(
            calibration_id: IdInPath, parts: PartsOf, _: Calibrator, by: By, seen: Version
        ) -> Response:
            """Bring a calibration into force, unless somebody else changed that meanwhile."""
            name = self.of(parts.station.store, calibration_id)
            self.activate(parts.station, name, calibration_id, seen=seen or None, by=by)
            return go_to(f"{self.address}/{calibration_id}")

        @routes.post("/refuse")
        def post_refuse(
            calibration_id: IdInPath, parts: PartsOf, _: Calibrator, by: By, why: Why
        ) -> Response:
            """Refuse a calibration."""
            self.refuse(parts.station, calibration_id, why=why, by=by)
            return go_to(f"{self.address}/{calibration_id}")

        return routes


def _sensor_of(store: Store, calibration_id: str) -> str:
    with store.look() as session:
        return the(session, Calibration, calibration_id).sensor


def _rig_of(store: Store, calibration_id: str) -> str:
    with store.look() as session:
        return the(session, RigCalibration, calibration_id).rig


for kind in (
    Decidable("/calibrations", _sensor_of, activate_calibration, refuse_calibration),
    Decidable("/rig-calibrations", _rig_of, activate_rig_calibration, refuse_rig_calibration),
):
    router.include_router(kind.routes())


@router.get("/calibration/recalibrations/{recalibration_id}")
def get_recalibration(
    recalibration_id: IdInPath, request: Request, parts: PartsOf, shell: ShellOf, _: Reader
) -> Response:
    """Return what a recalibration found and decided, and what it asks."""
    with parts.station.store.look() as session:
        row = the(session, Recalibration, recalibration_id)
    return shell.page(request, "calibration/recalibration.html", active="calibration", row=row)


@router.post("/calibration/recalibrations/{recalibration_id}/answer")
def post_answer(
    recalibration_id: IdInPath,
    parts: PartsOf,
    _: Calibrator,
    by: By,
    action: Annotated[Literal["activate", "refuse"], Form()],
    why: Why,
    seen: Annotated[int, Form(ge=1, le=2**31 - 1)],
) -> Response:
    """Answer a recalibration that asks."""
    bring = action == "activate"
    answer_recalibration(parts.station, recalibration_id, bring=bring, why=why, seen=seen, by=by)
    return go_to(f"/calibration/recalibrations/{recalibration_id}")
