"""Wheels for other programs: tables of readings and of points, MiniProf files."""

from station.exports.miniprof import write_miniprof
from station.exports.rows import COLUMNS, POINT_COLUMNS
from station.exports.tables import check_table_name, table_writer, write_points
from station.exports.targets import check_target, file_for_each, is_folder

__all__ = [
    "COLUMNS",
    "POINT_COLUMNS",
    "check_table_name",
    "check_target",
    "file_for_each",
    "is_folder",
    "table_writer",
    "write_miniprof",
    "write_points",
]
