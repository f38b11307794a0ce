"""Tables for people and data alike."""

from station.tables import Table


def test_table_is_markdown_with_a_column_a_key():
    table = Table("Title", [{"name": "one", "value": 0.123456, "ok": True}], ("A note.",))
    lines = table.as_markdown().splitlines()
    assert lines[0] == "Title"
    assert lines[2] == "| name | value  | ok  |"
    assert lines[4] == "| one  | 0.1235 | yes |"
    assert lines[-1] == "A note."


def test_table_as_data_keeps_every_digit():
    assert Table("t", [{"value": 0.123456}]).as_data()["rows"] == [{"value": 0.123456}]
