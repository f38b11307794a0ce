"""Logs: one JSON object a line on stderr, with the process that wrote it and what it is about."""

import json
import logging
import re
import sys
import threading
from collections.abc import Sequence

import structlog
from structlog.typing import EventDict, Processor, WrappedLogger

from station.settings import LogLevel

_SHARED: tuple[Processor, ...] = (
    structlog.contextvars.merge_contextvars,
    structlog.processors.add_log_level,
    structlog.processors.TimeStamper(fmt="iso", utc=True),
    structlog.processors.format_exc_info,
)
_LEVELS = {"debug": logging.DEBUG, "info": logging.INFO, "warning": logging.WARNING}
_SECRETS = re.compile(
    r"(?P<key>\btl_[0-9a-f]+_)[\w-]+"
    r"|(?P<header>\b(?:Bearer|Basic) )[^\s\"\\]+"
    r"|(?P<url>://[^/\s:@\"]+:)[^@\s\"]+(?=@)"
)
"""A key of the station, an Authorization header, the password in the URL of a database."""
_log = structlog.get_logger()


def log_as(process: str, level: LogLevel = "info") -> None:
    """Set up logging in a process of the station."""

    def name_process(_logger: WrappedLogger, _method: str, line: EventDict) -> EventDict:
        # Not a context variable: a thread of a library begins without any.
        line["process"] = process
        return line

    shared = (*_SHARED, name_process)
    structlog.configure(
        processors=[*shared, _render],
        wrapper_class=structlog.make_filtering_bound_logger(_LEVELS[level]),
        # Asked anew for every line: who replaces stderr afterwards gets what is logged afterwards.
        logger_factory=lambda *_: structlog.WriteLogger(sys.stderr),
        cache_logger_on_first_use=False,
    )
    _take_over_standard_logging(shared)


def log_process_as(process: str, level: LogLevel) -> None:
    """Set up logging in a process that is the station's alone: warnings and dying threads too."""
    log_as(process, level)
    logging.captureWarnings(True)
    threading.excepthook = _note_dead_thread


def _render(_logger: WrappedLogger, _method: str, line: EventDict) -> str:
    """Return a line as JSON; what looks like a secret is struck out, whoever let it slip in.

    Nothing here logs one on purpose: this is for the message of a library that quotes a URL.
    """
    return _SECRETS.sub(_struck_out, json.dumps(line, default=repr))


def _struck_out(found: re.Match[str]) -> str:
    return f"{found['key'] or found['header'] or found['url']}***"


class _ToStderr(logging.Handler):
    """Writes to what is stderr when something is logged, as the station's own lines are."""

    def emit(self, record: logging.LogRecord) -> None:
        try:
            sys.stderr.write(f"{self.format(record)}\n")
        except Exception:  # noqa: BLE001  a line that cannot be written is no reason to fail
            self.handleError(record)


def _take_over_standard_logging(shared: Sequence[Processor]) -> None:
    """Have what libraries say with the standard library's logging written the same way."""
    handler = _ToStderr()
    handler.setFormatter(
        structlog.stdlib.ProcessorFormatter(
            foreign_pre_chain=[*shared, structlog.stdlib.add_logger_name],
            processors=[structlog.stdlib.ProcessorFormatter.remove_processors_meta, _render],
        )
    )
    logging.basicConfig(level=logging.WARNING, handlers=[handler], force=True)
    # The engine of the jobs adds a handler of its own unless its logger has one.
    logging.getLogger("dbos").addHandler(logging.NullHandler())


def _note_dead_thread(died: threading.ExceptHookArgs) -> None:
    """Log the end of a thread that nobody foresaw, in place of a traceback over many lines."""
    name = None if died.thread is None else died.thread.name
    _log.error("a thread died", thread=name, exc_info=died.exc_value)
