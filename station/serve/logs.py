"""Logs: one JSON object a line on stderr, with the process that wrote it."""

import logging
import sys

import structlog


def log_as(process: str) -> None:
    """Set up logging in a process of the station."""
    structlog.configure(
        processors=[
            structlog.contextvars.merge_contextvars,
            structlog.processors.add_log_level,
            structlog.processors.TimeStamper(fmt="iso", utc=True),
            structlog.processors.format_exc_info,
            structlog.processors.JSONRenderer(),
        ],
        logger_factory=structlog.WriteLoggerFactory(file=sys.stderr),
        cache_logger_on_first_use=False,
    )
    structlog.contextvars.clear_contextvars()
    structlog.contextvars.bind_contextvars(process=process)
    # What libraries say with the standard library's logging goes the same way.
    logging.basicConfig(
        level=logging.WARNING,
        format='{"process": "' + process + '", "logger": "%(name)s", "event": "%(message)s"}',
        force=True,
    )
