"""Tables for people and data alike; the profile's picture draws what was measured."""

from xml.etree import ElementTree as ET

import numpy as np

from measure import Alarm, Status, reference_profile
from station.documents import ProfileDocument, ReadingDocument, WheelDocument
from station.plots import profile_svg
from station.tables import Table

SVG = "{http://www.w3.org/2000/svg}"


def test_table_is_markdown_with_a_column_a_key():
    table = Table("Title", [{"name": "one", "value": 0.123456, "ok": True}], ("A note.",))
    lines = table.as_markdown().splitlines()
    assert lines[0] == "Title"
    assert lines[2] == "| name | value  | ok  |"
    assert lines[4] == "| one  | 0.1235 | yes |"
    assert lines[-1] == "A note."


def test_table_as_data_keeps_every_digit():
    assert Table("t", [{"value": 0.123456}]).as_data()["rows"] == [{"value": 0.123456}]


def wheel(source="left.mcap"):
    reference = reference_profile("S1002")
    y, z = reference.points(1.0).T
    return WheelDocument(
        source=source,
        sensor="left",
        frame=3,
        flange_thickness_10=ReadingDocument(
            value=32.5, u95=0.05, status=Status.OK, alarm=Alarm.NONE
        ),
        profile=ProfileDocument(
            d_mm=tuple(y + 70.0), h_mm=tuple(z), sigma_mm=tuple(np.full(len(y), 0.01))
        ),
    )


def test_profile_lies_on_the_reference_it_was_made_of():
    root = ET.fromstring(profile_svg(wheel(), reference_profile("S1002")))
    lines = {
        line.get("class"): np.array([p.split(",") for p in line.get("points").split()], float)
        for line in root.iter(f"{SVG}polyline")
    }
    # The reference is drawn every 0.25 mm at 6 px a mm: its next point is 0.75 px away at most,
    # and both are rounded to 0.1 px.
    gap = np.abs(lines["measured"][:, None] - lines["reference"][None]).max(axis=2).min(axis=1)
    assert gap.max() <= 0.86
    assert len(list(root.iter(f"{SVG}line"))) == 2


def test_name_of_a_source_is_never_markup():
    root = ET.fromstring(profile_svg(wheel("<script>&"), reference_profile("S1002")))
    assert "<script>& frame 3" in [text.text for text in root.iter(f"{SVG}text")]
