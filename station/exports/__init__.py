"""Wheels for other programs: tables of readings and of points, MiniProf files."""

from station.exports.miniprof import miniprof_of, write_miniprof
from station.exports.rows import COLUMNS, POINT_COLUMNS, row_of
from station.exports.tables import check_table_name, table_writer, write_points, write_table
from station.exports.targets import check_target, file_for_each, is_folder

__all__ = [
    "COLUMNS",
    "POINT_COLUMNS",
    "check_table_name",
    "check_target",
    "file_for_each",
    "is_folder",
    "miniprof_of",
    "row_of",
    "table_writer",
    "write_miniprof",
    "write_points",
    "write_table",
]
