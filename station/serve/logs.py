"""Logs: one JSON object a line on stderr, with the process that wrote it."""

import logging
import sys

import structlog
from structlog.typing import Processor

_SHARED: tuple[Processor, ...] = (
    structlog.contextvars.merge_contextvars,
    structlog.processors.add_log_level,
    structlog.processors.TimeStamper(fmt="iso", utc=True),
    structlog.processors.format_exc_info,
)


def log_as(process: str) -> None:
    """Set up logging in a process of the station."""
    structlog.configure(
        processors=[*_SHARED, structlog.processors.JSONRenderer()],
        # Asked anew for every line: who replaces stderr afterwards gets what is logged afterwards.
        logger_factory=lambda *_: structlog.WriteLogger(sys.stderr),
        cache_logger_on_first_use=False,
    )
    structlog.contextvars.clear_contextvars()
    structlog.contextvars.bind_contextvars(process=process)
    _take_over_standard_logging()


def _take_over_standard_logging() -> None:
    """Have what libraries say with the standard library's logging written the same way."""
    handler = logging.StreamHandler()
    handler.setFormatter(
        structlog.stdlib.ProcessorFormatter(
            foreign_pre_chain=[*_SHARED, structlog.stdlib.add_logger_name],
            processors=[
                structlog.stdlib.ProcessorFormatter.remove_processors_meta,
                structlog.processors.JSONRenderer(),
            ],
        )
    )
    logging.basicConfig(level=logging.WARNING, handlers=[handler], force=True)
    # The engine of the jobs adds a handler of its own unless its logger has one.
    logging.getLogger("dbos").addHandler(logging.NullHandler())
