"""What a line of the log is about: the same names in every process, so that lines can be joined.

`request` is a call to the API, `pass`, `session`, `recording` and `job` are the station's own ids,
`sensor` is a sensor's.
"""

from collections.abc import Generator
from contextlib import contextmanager

from structlog.contextvars import bound_contextvars


@contextmanager
def about(
    *,
    request: str | None = None,
    pass_id: str | None = None,
    session: str | None = None,
    recording: str | None = None,
    job: str | None = None,
    kind: str | None = None,
    sensor: str | None = None,
) -> Generator[None]:
    """Have the lines that are logged in the block name what they are about; None names nothing."""
    names = {
        "request": request,
        "pass": pass_id,  # a keyword of the language
        "session": session,
        "recording": recording,
        "job": job,
        "kind": kind,
        "sensor": sensor,
    }
    with bound_contextvars(**{name: value for name, value in names.items() if value is not None}):
        yield
