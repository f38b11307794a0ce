"""What can be wrong with a station: how grave it is, what strangers may know of it, what to do."""

from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum

STORE = "store"
WORKER = "worker"
DISK = "disk"
CLOCK = "clock"
CONTROLLER = "controller"
FLEET = "fleet"


def part_of_sensor(sensor: str) -> str:
    """Return the name of a sensor as a part of the station."""
    return f"sensor {sensor}"


def part_of_rig(rig: str) -> str:
    """Return the name of a rig as a part of the station."""
    return f"rig {rig}"


class Severity(StrEnum):
    """How grave a trouble is."""

    CRITICAL = "critical"
    """The next train is not recorded, or not measured: the part is not ready."""
    WARNING = "warning"
    """It is recorded, but readings miss or may be wrong: the part is degraded."""
    NOTICE = "notice"
    """Somebody is waited for; nothing is lost meanwhile."""


class TroubleKind(StrEnum):
    """What is wrong, in one word for programs."""

    STORE_UNREACHABLE = "store_unreachable"
    WORKER_STOPPED = "worker_stopped"
    CAPTURE_SILENT = "capture_silent"
    CAMERA_LOST = "camera_lost"
    CAMERA_UNFIT = "camera_unfit"
    DISK_UNREADABLE = "disk_unreadable"
    DISK_SHORT = "disk_short"
    DISK_LOW = "disk_low"
    CLOCK_UNKEPT = "clock_unkept"
    CALIBRATION_MISSING = "calibration_missing"
    CALIBRATION_DOUBTFUL = "calibration_doubtful"
    RECALIBRATION_ASKS = "recalibration_asks"
    RECALIBRATION_FAILED = "recalibration_failed"
    FRAMES_LOST = "frames_lost"
    PASS_FAILED = "pass_failed"
    CONTROLLER_SILENT = "controller_silent"
    JOB_LATE = "job_late"
    FLEET_SILENT = "fleet_silent"


@dataclass(frozen=True, slots=True)
class _Meaning:
    severity: Severity
    public: str
    """What everybody may read: no address, no path, no name of the inside."""
    cure: str


_MEANINGS: dict[TroubleKind, _Meaning] = {
    TroubleKind.STORE_UNREACHABLE: _Meaning(
        Severity.CRITICAL,
        "does not answer",
        "look at the disk of the data, or at PostgreSQL where store_url names one",
    ),
    TroubleKind.WORKER_STOPPED: _Meaning(
        Severity.CRITICAL,
        "not running",
        "it is started again by itself; where it stays away, the station's log says why",
    ),
    TroubleKind.CAPTURE_SILENT: _Meaning(
        Severity.CRITICAL,
        "its capture process does not answer",
        "it is started again by itself; where it stays away, the station's log says why",
    ),
    TroubleKind.CAMERA_LOST: _Meaning(
        Severity.CRITICAL,
        "its camera is not there",
        "look at the camera's power and cable, and run `station doctor`",
    ),
    TroubleKind.CAMERA_UNFIT: _Meaning(
        Severity.WARNING,
        "its camera is not set up as it should be",
        "run `station doctor` on this host",
    ),
    TroubleKind.DISK_UNREADABLE: _Meaning(
        Severity.CRITICAL, "cannot be read", "look at the disk of data_dir"
    ),
    TroubleKind.DISK_SHORT: _Meaning(
        Severity.CRITICAL,
        "too little space for a pass",
        "delete or move recordings, or set quota_gb or keep_days in [storage]",
    ),
    TroubleKind.DISK_LOW: _Meaning(
        Severity.WARNING,
        "space for few passes",
        "delete or move recordings, or set quota_gb or keep_days in [storage]",
    ),
    TroubleKind.CLOCK_UNKEPT: _Meaning(
        Severity.WARNING, "not kept right", "run chrony or another NTP client on this host"
    ),
    TroubleKind.CALIBRATION_MISSING: _Meaning(
        Severity.WARNING,
        "without a calibration",
        "calibrate it and bring the calibration into force: passes are recorded, not measured",
    ),
    TroubleKind.CALIBRATION_DOUBTFUL: _Meaning(
        Severity.WARNING,
        "its calibration may measure wrongly",
        "look at the sensor's mount, then answer the recalibration or calibrate anew",
    ),
    TroubleKind.RECALIBRATION_ASKS: _Meaning(
        Severity.NOTICE,
        "its recalibration waits for a person",
        "read /v1/recalibrations/{id} and accept or refuse it",
    ),
    TroubleKind.RECALIBRATION_FAILED: _Meaning(
        Severity.NOTICE,
        "its last recalibration came to no decision",
        "read why, put it right, and order another: station recalibrate",
    ),
    TroubleKind.FRAMES_LOST: _Meaning(
        Severity.WARNING,
        "lost frames of its last pass",
        "look at cable, switch and packet size, and run `station doctor`",
    ),
    TroubleKind.PASS_FAILED: _Meaning(
        Severity.WARNING, "its last pass failed", "read the pass's reason"
    ),
    TroubleKind.CONTROLLER_SILENT: _Meaning(
        Severity.WARNING,
        "did not end the last pass",
        "look at the controller's link: the station ended the pass by itself",
    ),
    TroubleKind.JOB_LATE: _Meaning(
        Severity.WARNING,
        "a job waits for long",
        "see /v1/jobs for what runs; the host may be too slow for its trains",
    ),
    TroubleKind.FLEET_SILENT: _Meaning(
        Severity.NOTICE,
        "not reached for days",
        "look at the way to the fleet's database; nothing is lost, all is sent when it is back",
    ),
}


@dataclass(frozen=True, slots=True)
class Trouble:
    """Something that somebody should look at."""

    kind: TroubleKind
    part: str
    what: str
    """What was seen, for those who may know: it may hold addresses and names."""
    since: datetime
    """When it began, or was seen first by this process."""

    @property
    def severity(self) -> Severity:
        """How grave it is."""
        return _MEANINGS[self.kind].severity

    @property
    def public(self) -> str:
        """What everybody may read of it."""
        return _MEANINGS[self.kind].public

    @property
    def cure(self) -> str:
        """What to do."""
        return _MEANINGS[self.kind].cure
