"""Doing a step again that nothing is wrong with: the store was away, a helping process was killed.

A step that fails has failed for good, as the engine keeps its error.  What passes by is waited for
within the step, so that a recording that is whole does not stay without readings.
"""

import time
from collections.abc import Callable
from concurrent.futures import BrokenExecutor
from functools import wraps
from typing import ParamSpec, TypeVar

import structlog

from station.errors import StoreUnusable

PASSING = (StoreUnusable, BrokenExecutor)
"""Errors that say nothing of what is being worked on."""
_MOST_BROKEN = 3
"""Work whose processes are killed again and again, for their memory perhaps, has to end."""
_PAUSE_S = 1.0
_log = structlog.get_logger()

Given = ParamSpec("Given")
Answer = TypeVar("Answer")


def persevering(
    work: Callable[Given, Answer], sleep: Callable[[float], None] = time.sleep
) -> Callable[Given, Answer]:
    """Return work that is done again where it meets what passes by.

    The store is waited for without end: a worker that is told to stop meanwhile is ended by the
    supervisor, and the step is done after the next start.
    """

    @wraps(work)
    def again(*args: Given.args, **kwargs: Given.kwargs) -> Answer:
        broken = 0
        while True:
            try:
                return work(*args, **kwargs)
            except PASSING as error:
                broken += isinstance(error, BrokenExecutor)
                if broken == _MOST_BROKEN:
                    raise
                _log.warning("step to be done again", why=str(error) or type(error).__name__)
                sleep(_PAUSE_S)

    return again
