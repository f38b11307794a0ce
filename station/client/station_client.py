"""The calls on a station, by what a controller, a metrologist or a program wants."""

from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path

import httpx

from station.client.calibration_calls import CalibrationCalls
from station.client.calls import place_of
from station.client.connection import Answer, Connection, Patience
from station.client.following import follow
from station.errors import InputUnusable

_PIECE_BYTES = 1 << 20
_PATIENT = Patience()


class StationClient(CalibrationCalls):
    """A connection to one station.

    Every call is made again while the station cannot be reached or asks for it, within the
    patience; a controller's program needs no code of its own for that.  Raises `CallRefused` for
    every answer that is a refusal, `StationUnreachable` where nobody answers.
    """

    def __init__(self, http: httpx.Client, *, patience: Patience = _PATIENT) -> None:
        super().__init__(Connection(http, patience))

    @classmethod
    @contextmanager
    def connect(
        cls, url: str, key: str, *, timeout_s: float = 30.0, patience: Patience = _PATIENT
    ) -> Generator["StationClient"]:
        """Open a connection with a key of the station; `timeout_s` is for one try of a call."""
        headers = {"Authorization": f"Bearer {key}"}
        with httpx.Client(base_url=url, headers=headers, timeout=timeout_s) as http:
            yield cls(http, patience=patience)

    def ready(self) -> bool:
        """Tell whether the station and all its parts are ready; False where nobody answers."""
        return self._at.answers("/readyz")

    def station(self) -> Answer:
        """Return the sensors and rigs of the station, and how they are."""
        return self._at.call("GET", "/v1/station")

    def calibrated_sensors(self) -> list[str]:
        """Return the sensors that have a calibration in force."""
        return [each["id"] for each in self.station()["sensors"] if each["active_calibration"]]

    # Passes

    def arm_pass(
        self,
        pass_id: str,
        *,
        train: str | None = None,
        consist: Sequence[str | Answer] | None = None,
    ) -> Answer:
        """Say that a train comes, and on which wheelsets; the same call twice is one pass."""
        body = {"train": train, "consist": None if consist is None else list(consist)}
        return self._at.call("PUT", place_of("passes", pass_id), body)

    def finish_pass(
        self,
        pass_id: str,
        *,
        triggers: Mapping[str, int] | None = None,
        axles: int | None = None,
        consist: Sequence[str | Answer] | None = None,
    ) -> Answer:
        """Say that the train has gone, its axles, and how often each sensor was triggered."""
        body: Answer = {"triggers": dict(triggers or {}), "axles": axles}
        if consist is not None:
            body["consist"] = list(consist)
        return self._at.call("POST", f"{place_of('passes', pass_id)}/finish", body)

    def one_pass(self, pass_id: str) -> Answer:
        """Return the state of a pass and how its frames add up."""
        return self._at.call("GET", place_of("passes", pass_id))

    def passes(
        self,
        *,
        state: str | None = None,
        train: str | None = None,
        wheelset: str | None = None,
        since: datetime | None = None,
        until: datetime | None = None,
    ) -> Iterator[Answer]:
        """Yield passes, the newest first."""
        which = {"state": state, "train": train, "wheelset": wheelset, **_span(since, until)}
        return self._listed("/v1/passes", "passes", which)

    def await_pass(self, pass_id: str, *, timeout_s: float) -> Answer:
        """Wait until a pass is measured, or will not be, and return it."""
        return self._await(place_of("passes", pass_id), timeout_s)

    def wheels(self, pass_id: str) -> list[Answer]:
        """Return the measured wheels of a pass, with their profiles."""
        return list(self.measurements(pass_id=pass_id, profiles=True))

    def train(self, pass_id: str) -> Answer:
        """Return the axles of a measured pass in the order of passing, and the alarms."""
        return self._at.call("GET", f"{place_of('passes', pass_id)}/wheels")

    def measurements(
        self,
        *,
        pass_id: str | None = None,
        sensor: str | None = None,
        wheelset: str | None = None,
        side: str | None = None,
        replay: str | None = None,
        profiles: bool = False,
    ) -> Iterator[Answer]:
        """Yield measurements in the order they were made."""
        which = {"pass": pass_id, "sensor": sensor, "wheelset": wheelset, "side": side}
        which |= {"replay": replay, "profiles": "true" if profiles else None}
        return self._listed("/v1/measurements", "measurements", which, cursor="after")

    def trend(self, wheelset: str) -> Answer:
        """Return how the wheels of a wheelset change from pass to pass."""
        return self._at.call("GET", f"{place_of('wheelsets', wheelset)}/trend")

    # Jobs

    def job(self, job_id: str) -> Answer:
        """Return the state and progress of a job."""
        return self._at.call("GET", place_of("jobs", job_id))

    def jobs(
        self, *, state: str | None = None, kind: str | None = None, subject: str | None = None
    ) -> Iterator[Answer]:
        """Yield jobs, the newest first."""
        return self._listed("/v1/jobs", "jobs", {"state": state, "kind": kind, "subject": subject})

    def job_events(self, job_id: str) -> Iterator[Answer]:
        """Yield a job whenever it has changed, until it has ended."""
        return follow(self._at, f"{place_of('jobs', job_id)}/events")

    def cancel_job(self, job_id: str) -> Answer:
        """Cancel a job; what it worked on stays usable."""
        return self._at.call("DELETE", place_of("jobs", job_id))

    # Recordings

    def recordings(
        self,
        *,
        sensor: str | None = None,
        pass_id: str | None = None,
        session: str | None = None,
        since: datetime | None = None,
        until: datetime | None = None,
    ) -> Iterator[Answer]:
        """Yield recordings, the newest first."""
        which = {"sensor": sensor, "pass": pass_id, "session": session, **_span(since, until)}
        return self._listed("/v1/recordings", "recordings", which)

    def upload(self, file: Path) -> Answer:
        """Give the station a recording (MCAP) of elsewhere; the same one twice is one.

        Raises
        ------
        InputUnusable
            If there is no such file.
        """
        try:
            size = file.stat().st_size
        except OSError as error:
            raise InputUnusable(f"{file}: {error.strerror}; give a recording (.mcap)") from error
        headers = {"Content-Type": "application/octet-stream", "Content-Length": str(size)}
        reply = self._at.send(
            "POST", "/v1/recordings", headers=headers, content=lambda: _pieces(file)
        )
        answer: Answer = reply.json()
        return answer

    def picture(self, recording: str, number: int, *, max_width: int | None = None) -> bytes:
        """Return a frame of a recording, by its place from 1, as PNG."""
        place = f"{place_of('recordings', recording)}/frames/{number}/picture"
        return self._at.send("GET", place, params={"max_width": max_width}).content

    def replay(
        self,
        *,
        recordings: Sequence[str] = (),
        pass_id: str | None = None,
        calibrations: Mapping[str, str] | None = None,
        rig_calibration: str | None = None,
        reference: str | None = None,
        timeout_s: float,
    ) -> Answer:
        """Have recordings, or a pass, measured once more; wait, and return what came of it."""
        body: Answer = {"calibrations": dict(calibrations or {}), "reference": reference}
        body |= {"rig_calibration": rig_calibration, "recordings": list(recordings)}
        if pass_id is not None:
            body["pass"] = pass_id
        ordered = self._at.call("POST", "/v1/replays", body)
        self.await_job(ordered["job"], timeout_s=timeout_s)
        return self._at.call("GET", place_of("replays", ordered["id"]))


def _pieces(file: Path) -> Iterator[bytes]:
    with file.open("rb") as stream:
        while piece := stream.read(_PIECE_BYTES):
            yield piece


def _span(since: datetime | None, until: datetime | None) -> dict[str, str | None]:
    """Return the moments of a filter; one without a zone is of this host's."""
    moments = {"from": since, "to": until}
    return {
        name: None if moment is None else moment.astimezone().isoformat()
        for name, moment in moments.items()
    }
