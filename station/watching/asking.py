"""Asking what may never answer, without ever waiting for it long."""

import threading
import time
from collections.abc import Callable, Mapping
from typing import Generic, TypeVar

Answer = TypeVar("Answer")


class Asker(Generic[Answer]):
    """Asks the same question again and again; while one asking hangs, no other is begun.

    A process that is stopped, or a network disk that is gone, holds whoever asks it for as long as
    it likes: it gets one thread to hold, which does not keep this process from ending.
    """

    def __init__(self, name: str, ask: Callable[[], Answer]) -> None:
        self._name = name
        self._ask = ask
        self._thread: threading.Thread | None = None
        self._answer: Answer | Exception | None = None

    @property
    def hangs(self) -> bool:
        """Whether the last asking has not come to its end."""
        return self._thread is not None and self._thread.is_alive()

    def begin(self) -> None:
        """Ask, unless the last asking still hangs."""
        if not self.hangs:
            self._answer = None
            self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
            self._thread.start()

    def wait(self, seconds: float) -> Answer | Exception | None:
        """Return the answer or the error it ended in; None where it hangs for longer."""
        if self._thread is not None:
            self._thread.join(max(seconds, 0.0))
        return None if self.hangs else self._answer

    def _run(self) -> None:
        try:
            self._answer = self._ask()
        except Exception as error:  # noqa: BLE001  whatever is wrong with it is the answer
            self._answer = error


def answers_of(
    askers: Mapping[str, Asker[Answer]], patience_s: float
) -> dict[str, Answer | Exception | None]:
    """Ask all at a time and return what they answer; one that hung before is not waited for."""
    hung = {name for name, asker in askers.items() if asker.hangs}
    for asker in askers.values():
        asker.begin()
    deadline = time.monotonic() + patience_s
    return {
        name: asker.wait(0.0 if name in hung else deadline - time.monotonic())
        for name, asker in askers.items()
    }
