"""Examining the host in a process of its own: it takes seconds, and the disk all that time.

``python -m station.doctor.examining`` reads the patient from stdin, as `patient_as_text` gives it,
and prints one JSON document: the findings, or why there are none.
"""

import json
import os
import sys
from dataclasses import asdict
from pathlib import Path

from station.doctor.demand import Stream
from station.doctor.examine import Patient, examine
from station.errors import StationError
from station.settings import StorageSettings

_NICE = 10


def patient_as_text(patient: Patient) -> str:
    """Return a patient as the process takes it."""
    return json.dumps({
        "folder": str(patient.folder),
        "streams": [asdict(stream) for stream in patient.streams],
        "storage": patient.storage.model_dump(mode="json"),
    })


def patient_of_text(text: str) -> Patient:
    """Return the patient that `patient_as_text` told of."""
    told = json.loads(text)
    return Patient(
        folder=Path(told["folder"]),
        streams=tuple(Stream(**each) for each in told["streams"]),
        storage=StorageSettings(**told["storage"]),
    )


def main() -> None:
    """Print what is found, behind all that records and measures."""
    os.nice(_NICE)
    found: dict[str, object]
    try:
        found = {
            "findings": [each.to_json() for each in examine(patient_of_text(sys.stdin.read()))]
        }
    except StationError as error:
        found = {"refused": str(error)}
    sys.stdout.write(json.dumps(found))


if __name__ == "__main__":
    main()
