"""Letting go of driver objects whose camera is silent.

Their end writes registers of a camera that no longer answers, 2.5 s each; the capture process has
better things to do.  The interpreter's lock is not held meanwhile.
"""

import threading
from typing import Any


def bury(objects: list[Any]) -> None:
    """Empty the list in a thread of its own; the caller must hold no other references."""
    threading.Thread(target=objects.clear, name="burial", daemon=True).start()
