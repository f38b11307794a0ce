"""The way from the API to the worker: by the engine's client, without running anything here."""

from functools import cached_property
from typing import TYPE_CHECKING

import structlog

from station.store import JobKind

if TYPE_CHECKING:
    from dbos import DBOSClient

APPLICATION = "treadline"
# Fixed, so that a worker started anew, of a newer version too, takes up what the last one left.
EXECUTOR_ID = "worker-1"
APPLICATION_VERSION = "1"

_log = structlog.get_logger()


class WorkerQueue:
    """Tells the worker of jobs at once.

    The store has the job already, and the worker looks there too: a message that does not get
    through costs a second, not the job.
    """

    def __init__(self, jobs_url: str) -> None:
        self._jobs_url = jobs_url

    def submit(self, kind: JobKind, job_id: str) -> None:
        """Tell the worker of a job; it does not matter if it is told twice or never."""
        try:
            self._client.enqueue(
                {
                    "workflow_name": kind.value,
                    "queue_name": kind.value,
                    "workflow_id": job_id,
                    "app_version": APPLICATION_VERSION,
                },
                job_id,
            )
            # In the API the line names the request too: so a job's lines lead to who ordered it.
            _log.info("job ordered", job=job_id, kind=kind.value)
        except Exception as error:  # noqa: BLE001  the engine's client raises whatever its database does
            _log.warning("worker not told of a job", job=job_id, error=str(error))

    def cancel(self, job_id: str) -> None:
        """Tell the worker not to begin, or not to go on with, a job."""
        try:
            self._client.cancel_workflow(job_id)
        except Exception as error:  # noqa: BLE001  as above; the store says cancelled, which is what counts
            _log.warning("worker not told of a cancelled job", job=job_id, error=str(error))

    @cached_property
    def _client(self) -> "DBOSClient":
        from dbos import DBOSClient  # noqa: PLC0415  costs 0.8 s, which the start need not wait for

        return DBOSClient(
            system_database_url=self._jobs_url, application_name=APPLICATION, lazy=True
        )
