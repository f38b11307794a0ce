"""A thread of the API process that looks after passes and sessions whose controller is lost."""

import threading
from collections.abc import Callable

import structlog

_EVERY_S = 1.0
_log = structlog.get_logger()


def begin_looking(
    look: Callable[[], None], stop: threading.Event, every_s: float = _EVERY_S
) -> threading.Thread:
    """Call `look` at once and then about once a second, beside all else, until `stop` is set.

    A look that fails is logged, and the next one comes all the same: passes must end.
    """
    thread = threading.Thread(
        target=_go_on, args=(look, stop, every_s), name="lifetimes", daemon=True
    )
    thread.start()
    return thread


def _go_on(look: Callable[[], None], stop: threading.Event, every_s: float) -> None:
    before = None
    while not stop.is_set():
        try:
            look()
        except Exception as error:  # noqa: BLE001  whatever it was, the next look must come
            if repr(error) != before:  # a store that is away for an hour is said once
                _log.warning("passes not looked after", why=repr(error), exc_info=error)
            before = repr(error)
        else:
            before = None
        stop.wait(every_s)
