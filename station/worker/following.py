"""The thread that measures passes while they are recorded.

It is an accelerator and no source of truth: the job that measures a finished pass takes over what
is certain, measures the rest, and needs nothing of what is here.
"""

import threading
import time
from collections.abc import Callable

import structlog

from station.errors import StationError
from station.store import PassState, passes_held
from station.worker.context import WorkContext
from station.worker.followed import FollowedRecordings
from station.worker.gathering import gathered

_LOOK_S = 0.2
"""Between looks for a pass; its first frame is not waited for, so it may be found a little late."""
_POLL_S = 0.02
_BREATH_S = 0.0005
"""Between turns, so that whoever wants a pass let go gets his turn."""
_BEHIND_S = 1.0
_log = structlog.get_logger()


class PassFollower:
    """Follows the passes that are being recorded, a turn of each looker after the other."""

    def __init__(self, context: WorkContext, clock_s: Callable[[], float] = time.monotonic) -> None:
        self._context, self._clock_s = context, clock_s
        self._stop = threading.Event()
        self._busy = threading.Lock()
        self._followed: dict[str, list[FollowedRecordings]] = {}
        self._looked_s = -_LOOK_S
        self._thread = threading.Thread(target=self._run, name="follow passes", daemon=True)

    def start(self) -> None:
        """Begin to follow."""
        self._thread.start()

    def stop(self) -> None:
        """End after the turn in hand; what was kept is gone on with after the next start."""
        self._stop.set()
        if self._thread.is_alive():
            self._thread.join()
        for pass_id in list(self._followed):
            self._drop(pass_id)

    def let_go(self, pass_id: str) -> None:
        """Follow a pass no longer; its readings are only the caller's then."""
        with self._busy:
            self._complete(pass_id)

    def _run(self) -> None:
        while not self._stop.is_set():
            try:
                with self._busy:
                    worked = self.turn()
            except Exception as error:  # noqa: BLE001  the store, most likely; the next look may do
                _log.warning("passes not followed for now", why=str(error))
                worked = False
            self._stop.wait(_BREATH_S if worked else _POLL_S)

    def turn(self) -> bool:
        """Give each looker its turn; False where no frame had come."""
        if self._clock_s() - self._looked_s >= _LOOK_S:
            self._look()
            self._looked_s = self._clock_s()
        lookers = [(pass_id, each) for pass_id, own in self._followed.items() for each in own]
        worked = [self._turn_of(pass_id, each) for pass_id, each in lookers]
        return any(worked)

    def _look(self) -> None:
        """Take up the passes that are recorded, and drop those that are so no more."""
        with self._context.store.look() as session:
            recorded = {row.id for row in passes_held(session) if row.state is PassState.RECORDING}
        for pass_id in self._followed.keys() - recorded:
            self._complete(pass_id)
        for pass_id in recorded - self._followed.keys():
            self._followed[pass_id] = self._begin(pass_id)

    def _begin(self, pass_id: str) -> list[FollowedRecordings]:
        try:
            groups = gathered(self._context, pass_id)
            return [FollowedRecordings(self._context, each, self._clock_s) for each in groups]
        except Exception as error:  # noqa: BLE001  whatever it is, the job that comes will say it
            self._give_up(pass_id, error)
            return []

    def _turn_of(self, pass_id: str, each: FollowedRecordings) -> bool:
        try:
            return each.turn()
        except Exception as error:  # noqa: BLE001  as above; another looker goes on
            self._give_up(pass_id, error)
            each.close()
            self._followed[pass_id].remove(each)
        return False

    def _complete(self, pass_id: str) -> None:
        """Keep the last wheels of a pass that is recorded no more, where they are soon measured."""
        for each in self._followed.get(pass_id, []):
            try:
                each.complete()
            except Exception as error:  # noqa: BLE001  as above
                self._give_up(pass_id, error)
        self._drop(pass_id)

    def _give_up(self, pass_id: str, error: Exception) -> None:
        expected = isinstance(error, StationError)
        _log.warning(
            "pass not measured while it is recorded",
            pass_id=pass_id,
            why=str(error),
            exc_info=None if expected else error,
        )

    def _drop(self, pass_id: str) -> None:
        for each in self._followed.pop(pass_id, []):
            each.close()
            say = _log.warning if each.behind_s > _BEHIND_S else _log.info
            say(
                "pass followed",
                pass_id=pass_id,
                wheels=each.wheels,
                withdrawn=each.withdrawn,
                behind_s=round(each.behind_s, 3),
            )
