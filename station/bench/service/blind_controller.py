"""A controller that says everything again until it is answered, as a PLC does."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from threading import Event

import httpx

from station.client import Answer, CallRefused, StationClient
from station.errors import StationError

_AGAIN_S = 0.1
_SERVER_ERROR = 500
_ENDED = {"done", "failed", "recovered"}


@dataclass(slots=True)
class BlindController:
    """One controller at its connection; it gives up what is not answered in `patience_s`."""

    client: StationClient
    sensor: str
    patience_s: float
    server_errors: int = 0
    """Answers that blamed the station itself."""

    def take_pass(self, pass_id: str, *, axles: int, gone: Event) -> Answer:
        """Arm, wait until the train has gone, finish, and wait for the pass's end.

        Returns
        -------
        answer
            The pass as the station shows it in the end; in whatever state it is stuck where the
            patience is over.
        """
        self._say(lambda: self.client.arm_pass(pass_id))
        gone.wait(self.patience_s)
        counted = {self.sensor: axles}
        self._say(lambda: self.client.finish_pass(pass_id, triggers=counted, axles=axles))
        return self._ended(pass_id)

    def _ended(self, pass_id: str) -> Answer:
        until_s = time.monotonic() + self.patience_s
        while True:
            answer = self._say(lambda: self.client.await_pass(pass_id, timeout_s=_AGAIN_S))
            if answer is None:
                raise StationError(f"the station knows nothing of pass {pass_id}")
            if answer.get("state") in _ENDED or time.monotonic() > until_s:
                return answer

    def _say(self, call: Callable[[], Answer]) -> Answer | None:
        """Call until there is an answer; None where it is a refusal: that is one, too."""
        until_s = time.monotonic() + self.patience_s
        while True:
            try:
                return call()
            except CallRefused as refused:
                if refused.status < _SERVER_ERROR:
                    return None
                self.server_errors += refused.status == _SERVER_ERROR
                why = str(refused)
            except (httpx.TransportError, StationError) as error:
                why = str(error)
            if time.monotonic() > until_s:
                raise StationError(f"no answer in {self.patience_s:g} s; the last word: {why}")
            time.sleep(_AGAIN_S)
