"""Versions as entity tags."""

import re

from station.errors import InputUnusable


def etag_of(version: int) -> str:
    """Return the tag of a version.

    >>> etag_of(3)
    '"3"'
    """
    return f'"{version}"'


def version_in(if_match: str | None) -> int | None:
    """Return the version that an If-Match header names; None where there is no header.

    Raises
    ------
    InputUnusable
        If it is not one of the station's tags.

    Examples
    --------
    >>> version_in('"3"')
    3
    """
    if if_match is None:
        return None
    match = re.fullmatch(r'"(\d{1,9})"', if_match.strip())
    if match is None:
        raise InputUnusable(f"If-Match {if_match!r}: send the ETag that reading gave, as it came")
    return int(match[1])
