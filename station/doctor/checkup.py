"""The last examination of the host, and another one when somebody asks for it."""

import json
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime

from station.doctor.examine import Patient
from station.doctor.examining import patient_as_text
from station.doctor.finding import Finding
from station.errors import NothingMeasurable, StateConflict, StationError

_PATIENCE_S = 180.0


@dataclass(frozen=True, slots=True)
class Examination:
    """What one examination found, and when."""

    began_at: datetime
    ended_at: datetime
    findings: Sequence[Finding] = ()
    problem: str | None = None
    """Why it found nothing."""


class Checkup:
    """Has the host examined by another process, one examination at a time.

    Parameters
    ----------
    examine
        Makes the examination; it raises StationError where it cannot.
    now
        The time by the host's clock.
    """

    def __init__(self, examine: Callable[[], Sequence[Finding]], now: Callable[[], datetime]):
        self._examine = examine
        self._now = now
        self._lock = threading.Lock()
        self._began_at: datetime | None = None
        self._last: Examination | None = None

    @property
    def last(self) -> Examination | None:
        """The last examination that has ended; None since this process began."""
        return self._last

    @property
    def began_at(self) -> datetime | None:
        """When the examination that goes on began; None where none does."""
        return self._began_at

    def begin(self) -> None:
        """Begin an examination; `last` has it when it has ended.

        Raises
        ------
        StateConflict
            If one goes on.
        """
        with self._lock:
            if self._began_at is not None:
                raise StateConflict("the host is being examined already; wait", state="running")
            self._began_at = began_at = self._now()
        threading.Thread(target=self._run, args=(began_at,), name="checkup", daemon=True).start()

    def _run(self, began_at: datetime) -> None:
        findings: Sequence[Finding] = ()
        problem = None
        try:
            findings = self._examine()
        except StationError as error:
            problem = str(error)
        finally:
            with self._lock:
                self._last = Examination(began_at, self._now(), findings, problem)
                self._began_at = None


def examine_apart(patient: Patient) -> list[Finding]:
    """Return what an examination in a process of its own finds.

    Raises
    ------
    NothingMeasurable
        If it was refused, or did not come to an end.
    """
    command = [sys.executable, "-m", "station.doctor.examining"]
    try:
        done = subprocess.run(
            command,
            input=patient_as_text(patient),
            capture_output=True,
            text=True,
            timeout=_PATIENCE_S,
            check=True,
        )
        found = json.loads(done.stdout)
    except subprocess.TimeoutExpired as error:
        raise NothingMeasurable(
            f"the examination did not end within {_PATIENCE_S:g} s; type: station doctor"
        ) from error
    except (subprocess.SubprocessError, OSError, ValueError) as error:
        raise NothingMeasurable(
            "the examination ended without an answer; type: station doctor"
        ) from error
    if "refused" in found:
        raise NothingMeasurable(found["refused"])
    return [Finding(each["name"], each["seen"], each["cure"]) for each in found["findings"]]
