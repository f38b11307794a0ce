"""Ways to look at a train."""

from enum import StrEnum


class Showing(StrEnum):
    """As a row of axles, or as a table with every reading."""

    ROW = "row"
    TABLE = "table"
