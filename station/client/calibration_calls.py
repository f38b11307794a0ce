"""Calibrating sensors and rigs."""

from collections.abc import Iterator, Mapping

from station.client.calls import Calls, place_of
from station.client.connection import Answer


class CalibrationCalls(Calls):
    """What a metrologist asks of a station."""

    def open_calibration_session(self, session_id: str, *, sensor: str, target: str) -> Answer:
        """Have a sensor wait for pictures of a target."""
        body = {"sensor": sensor, "target": target}
        return self._at.call("PUT", place_of("calibration-sessions", session_id), body)

    def open_rig_session(self, session_id: str, *, rig: str, targets: Mapping[str, str]) -> Answer:
        """Have all sensors of a rig wait for pictures, each of its own target."""
        body = {"rig": rig, "target": next(iter(targets.values())), "targets": dict(targets)}
        return self._at.call("PUT", place_of("calibration-sessions", session_id), body)

    def capture(self, session_id: str) -> Answer:
        """Take one picture of the target with each sensor of the session."""
        return self._at.call("POST", f"{place_of('calibration-sessions', session_id)}/capture")

    def finish_calibration_session(self, session_id: str) -> Answer:
        """Close the recording of a session."""
        return self._at.call("POST", f"{place_of('calibration-sessions', session_id)}/finish")

    def calibrate(self, *, sensor: str, session: str, method: str, timeout_s: float) -> Answer:
        """Have a sensor calibrated from a session, wait, and return the calibration."""
        body = {"sensor": sensor, "session": session, "method": method}
        return self._made("calibrations", body, timeout_s)

    def calibrate_rig(
        self, *, rig: str, session: str, board_sigma_mm: float, timeout_s: float
    ) -> Answer:
        """Have a rig calibrated from a session, wait, and return the calibration."""
        body = {"rig": rig, "session": session, "board_sigma_mm": board_sigma_mm}
        return self._made("rig-calibrations", body, timeout_s)

    def recalibrate(self, *, sensor: str, timeout_s: float) -> Answer:
        """Have a sensor recalibrated as its schedule would, wait, and return what came of it."""
        return self._made("recalibrations", {"sensor": sensor}, timeout_s)

    def calibrations(self, *, sensor: str | None = None) -> Iterator[Answer]:
        """Yield calibrations of sensors, the newest first, without their files."""
        return self._listed("/v1/calibrations", "calibrations", {"sensor": sensor})

    def calibration_points(self, calibration_id: str) -> str:
        """Return points.csv of a calibration."""
        return self._at.send("GET", f"{place_of('calibrations', calibration_id)}/points").text

    def activate(self, *, sensor: str, calibration: str) -> Answer:
        """Bring a first calibration into force on a sensor."""
        return self._activate(place_of("sensors", sensor), calibration)

    def activate_rig(self, *, rig: str, calibration: str) -> Answer:
        """Bring a first calibration into force on a rig."""
        return self._activate(place_of("rigs", rig), calibration)

    def _activate(self, path: str, calibration: str) -> Answer:
        body = {"calibration": calibration}
        headers = {"If-None-Match": "*"}
        return self._at.call("PUT", f"{path}/active-calibration", body, headers=headers)
