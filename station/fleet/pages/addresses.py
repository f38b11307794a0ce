"""Where in the folder a page lies: by names that any file system and web server takes."""

import re
from hashlib import sha256

from measure import Side

OVERVIEW = "index.html"
SENSORS = "sensors.html"
_LONGEST = 40
_UNSAFE = re.compile(r"[^A-Za-z0-9-]+")
MADE = re.compile(r"(wheels/[A-Za-z0-9-]*-[0-9a-f]{12}-(left|right)|names/[0-9]{4})\.html")
"""What a page that may be there no longer is called: nothing else is ever removed."""


def wheel_address(wheelset: str, side: Side) -> str:
    """Return the page of a wheel, for as long as its wheelset keeps its name.

    The digest tells apart what differs only in letters that no file's name may have, or by case.

    >>> wheel_address("../WS 1", Side.LEFT)
    'wheels/WS-1-e7d652e707c3-left.html'
    """
    shown = _UNSAFE.sub("-", wheelset)[:_LONGEST].strip("-")
    return f"wheels/{shown}-{sha256(wheelset.encode()).hexdigest()[:12]}-{side.value}.html"


def names_address(number: int) -> str:
    """Return the page of a group of names, counted from 1.

    >>> names_address(7)
    'names/0007.html'
    """
    return f"names/{number:04}.html"
