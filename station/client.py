"""The calls a trackside controller makes, in Python; `README.md` shows the same with curl."""

import time
from collections.abc import Generator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any
from urllib.parse import quote

import httpx

from station.errors import StationError

_ENDED = {"done", "failed", "recovered", "cancelled"}
_POLL_S = 0.2

Answer = dict[str, Any]


class CallRefused(StationError):
    """The station refused a call; the message is the detail of its problem document."""

    def __init__(self, status: int, detail: str) -> None:
        super().__init__(f"HTTP {status}: {detail}")
        self.status = status


class StationClient:
    """A connection to one station.

    Raises `CallRefused` for every answer that is a refusal, httpx errors where nobody answers.
    """

    def __init__(self, http: httpx.Client) -> None:
        self._http = http

    @classmethod
    @contextmanager
    def connect(cls, url: str, key: str, *, timeout_s: float = 30.0) -> Generator["StationClient"]:
        """Open a connection with a key of the station."""
        headers = {"Authorization": f"Bearer {key}"}
        with httpx.Client(base_url=url, headers=headers, timeout=timeout_s) as http:
            yield cls(http)

    def ready(self) -> bool:
        """Tell whether the station and all its parts are ready; False where nobody answers."""
        try:
            return self._http.get("/readyz").status_code == httpx.codes.OK
        except httpx.TransportError:
            return False

    def arm_pass(
        self, pass_id: str, *, train: str | None = None, consist: Sequence[str] | None = None
    ) -> Answer:
        """Say that a train comes, and on which wheelsets; the same call twice is one pass."""
        body = {"train": train, "consist": None if consist is None else list(consist)}
        return self._call("PUT", f"/v1/passes/{_part(pass_id)}", body)

    def finish_pass(
        self, pass_id: str, *, triggers: Mapping[str, int], axles: int | None = None
    ) -> Answer:
        """Say that the train has gone, its axles, and how often each sensor was triggered."""
        body = {"triggers": dict(triggers), "axles": axles}
        return self._call("POST", f"/v1/passes/{_part(pass_id)}/finish", body)

    def wheels(self, pass_id: str) -> list[Answer]:
        """Return the measured wheels of a pass, with their profiles."""
        wheels: list[Answer] = []
        of_pass = f"/v1/measurements?profiles=true&pass={_part(pass_id)}"
        after: int | None = 0
        while after is not None:
            page = self._call("GET", f"{of_pass}&after={after}")
            wheels += page["measurements"]
            after = page["next"]
        return wheels

    def train(self, pass_id: str) -> Answer:
        """Return the axles of a measured pass, in the order of passing."""
        return self._call("GET", f"/v1/passes/{_part(pass_id)}/wheels")

    def await_pass(self, pass_id: str, *, timeout_s: float) -> Answer:
        """Wait until a pass is measured, and return it."""
        return self._await(f"/v1/passes/{_part(pass_id)}", timeout_s)

    def open_calibration_session(self, session_id: str, *, sensor: str, target: str) -> Answer:
        """Have a sensor wait for pictures of a target."""
        body = {"sensor": sensor, "target": target}
        return self._call("PUT", f"/v1/calibration-sessions/{_part(session_id)}", body)

    def open_rig_session(self, session_id: str, *, rig: str, targets: Mapping[str, str]) -> Answer:
        """Have all sensors of a rig wait for pictures, each of its own target."""
        body = {"rig": rig, "target": next(iter(targets.values())), "targets": dict(targets)}
        return self._call("PUT", f"/v1/calibration-sessions/{_part(session_id)}", body)

    def capture(self, session_id: str) -> Answer:
        """Take one picture of the target with each sensor of the session."""
        return self._call("POST", f"/v1/calibration-sessions/{_part(session_id)}/capture")

    def finish_calibration_session(self, session_id: str) -> Answer:
        """Close the recording of a session."""
        return self._call("POST", f"/v1/calibration-sessions/{_part(session_id)}/finish")

    def calibrate(self, *, sensor: str, session: str, method: str, timeout_s: float) -> Answer:
        """Have a sensor calibrated from a session, wait, and return the calibration."""
        body = {"sensor": sensor, "session": session, "method": method}
        ordered = self._call("POST", "/v1/calibrations", body)
        self._await(f"/v1/jobs/{_part(ordered['job'])}", timeout_s)
        return self._call("GET", f"/v1/calibrations/{_part(ordered['id'])}")

    def calibrate_rig(
        self, *, rig: str, session: str, board_sigma_mm: float, timeout_s: float
    ) -> Answer:
        """Have a rig calibrated from a session, wait, and return the calibration."""
        body = {"rig": rig, "session": session, "board_sigma_mm": board_sigma_mm}
        ordered = self._call("POST", "/v1/rig-calibrations", body)
        self._await(f"/v1/jobs/{_part(ordered['job'])}", timeout_s)
        return self._call("GET", f"/v1/rig-calibrations/{_part(ordered['id'])}")

    def calibrated_sensors(self) -> list[str]:
        """Return the sensors that have a calibration in force."""
        sensors = self._call("GET", "/v1/station")["sensors"]
        return [each["id"] for each in sensors if each["active_calibration"]]

    def recalibrate(self, *, sensor: str, timeout_s: float) -> Answer:
        """Have a sensor recalibrated as its schedule would, wait, and return what came of it."""
        ordered = self._call("POST", "/v1/recalibrations", {"sensor": sensor})
        self._await(f"/v1/jobs/{_part(ordered['job'])}", timeout_s)
        return self._call("GET", f"/v1/recalibrations/{_part(ordered['id'])}")

    def calibration_points(self, calibration_id: str) -> str:
        """Return points.csv of a calibration."""
        return self._send("GET", f"/v1/calibrations/{_part(calibration_id)}/points").text

    def activate(self, *, sensor: str, calibration: str) -> Answer:
        """Bring a first calibration into force on a sensor."""
        return self._activate(f"/v1/sensors/{_part(sensor)}", calibration)

    def activate_rig(self, *, rig: str, calibration: str) -> Answer:
        """Bring a first calibration into force on a rig."""
        return self._activate(f"/v1/rigs/{_part(rig)}", calibration)

    def _activate(self, path: str, calibration: str) -> Answer:
        body = {"calibration": calibration}
        headers = {"If-None-Match": "*"}
        return self._call("PUT", f"{path}/active-calibration", body, headers)

    def _await(self, path: str, timeout_s: float) -> Answer:
        deadline = time.monotonic() + timeout_s
        while True:
            answer = self._call("GET", path)
            if answer["state"] in _ENDED:
                return answer
            if time.monotonic() > deadline:
                raise StationError(
                    f"{path} is still {answer['state']} after {timeout_s:g} s; look at the "
                    "station's log, or wait longer"
                )
            time.sleep(_POLL_S)

    def _call(
        self,
        method: str,
        path: str,
        body: Answer | None = None,
        headers: Mapping[str, str] | None = None,
    ) -> Answer:
        answer: Answer = self._send(method, path, body, headers).json()
        return answer

    def _send(
        self,
        method: str,
        path: str,
        body: Answer | None = None,
        headers: Mapping[str, str] | None = None,
    ) -> httpx.Response:
        reply = self._http.request(method, path, json=body, headers=headers)
        if reply.is_error:
            answer = reply.json()
            raise CallRefused(reply.status_code, str(answer.get("detail", answer)))
        return reply


def _part(name: str) -> str:
    return quote(name, safe="")
