"""The drawing of a profile shows what was measured, where it was measured, and how sure it is.

That it can be read is judged by eye.
"""

import re
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from profile_files import S1002, miniprof_file, profile

from measure import Quantity
from station.documents import WheelDocument
from station.pipeline import gauge_files
from station.plots import profile_svg, write_plots

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture
def wheel(tmp_path):
    header = {"Sh": "29.1"}
    return gauge_files([miniprof_file(tmp_path / "a.whl", header, worn_mm=1.0)]).wheels[0]


def drawn(*wheels):
    return ET.fromstring(profile_svg(wheels, S1002))


def points(element):
    return np.array([pair.split(",") for pair in element.get("points").split()], dtype=float)


def named(root, tag, name):
    return [each for each in root.iter(f"{SVG}{tag}") if each.get("class") == name]


def words(root):
    return [text.text for text in root.iter(f"{SVG}text")]


def in_mm(element):
    """Undo the drawing's scale: 6 px a mm, the flange back at x = 106, the tape circle at 526."""
    x, y = points(element).T
    return (x - 106.0) / 6.0, (256.0 - y) / 6.0


def test_profile_and_reference_lie_where_they_were_measured(wheel):
    root = drawn(wheel)
    d, h = in_mm(named(root, "polyline", "measured")[0])
    # Rounded to 0.1 px.
    np.testing.assert_allclose(d, wheel.profile.d_mm, atol=0.01)
    np.testing.assert_allclose(h, wheel.profile.h_mm, atol=0.01)
    d, h = in_mm(named(root, "polyline", "reference")[0])
    on_tread = d > 1.0
    np.testing.assert_allclose(h[on_tread], S1002.height_mm(d[on_tread] - 70.0), atol=0.05)


def test_parts_of_a_profile_are_drawn_by_the_sensors_that_saw_them(wheel):
    count = len(wheel.profile.d_mm)
    seen_by = [1] * (count // 3) + [3] * (count // 3) + [2] * (count - 2 * (count // 3))
    of_rig = wheel.profile.model_copy(update={"sensors": ("inner", "outer"), "seen_by": seen_by})
    root = drawn(wheel.model_copy(update={"profile": of_rig}))
    parts = [named(root, "polyline", f"measured by-{name}") for name in ("1", "several", "2")]
    assert [len(part) for part in parts] == [1, 1, 1]
    (inner,), (both,), (outer,) = parts
    # Each goes on to the next: there is no gap in the line.
    np.testing.assert_array_equal(points(inner)[-1], points(both)[0])
    np.testing.assert_array_equal(points(both)[-1], points(outer)[0])
    assert {"inner", "outer", "several"} <= set(words(root))
    assert "several" not in words(drawn(wheel))


def test_gauges_are_drawn_at_their_values(wheel):
    root = drawn(wheel)
    lengths = sorted(
        round((abs(float(g.get("x2")) - float(g.get("x1"))) / 6.0), 1)
        or round((abs(float(g.get("y2")) - float(g.get("y1"))) / 6.0), 1)
        for g in named(root, "line", "gauge")
    )
    values = sorted(
        round(wheel.readings[quantity].value, 1)
        for quantity in (
            Quantity.FLANGE_HEIGHT,
            Quantity.FLANGE_THICKNESS_10,
            Quantity.FLANGE_THICKNESS_12,
            Quantity.FLANGE_GRADIENT_QR,
        )
    )
    assert lengths == pytest.approx(values, abs=0.11)
    # Both of qR's points are on the profile.
    d, h = in_mm(named(root, "polyline", "measured")[0])
    for dot in named(root, "circle", "touch")[:2]:
        place = (float(dot.get("cx")) - 106.0) / 6.0, (256.0 - float(dot.get("cy"))) / 6.0
        assert np.hypot(d - place[0], h - place[1]).min() < 0.2


def test_wear_is_drawn_with_its_band(wheel):
    root = drawn(wheel)
    (line,) = named(root, "polyline", "wear-line")
    band = named(root, "polygon", "band")[-1]
    _, y = points(line).T
    upper, lower = np.split(points(band)[:, 1], 2)
    assert (upper <= y + 0.1).all()
    assert (lower[::-1] >= y - 0.1).all()
    assert "most: 1.00 at d" in " ".join(words(root))


def test_readings_and_what_the_header_says_are_listed(wheel):
    said = words(drawn(wheel))
    reading = wheel.flange_height
    assert f"{reading.value:.2f} \u00b1 {reading.u95:.2f} mm" in said
    assert "29.10" in said
    assert "header says" in said
    assert "missing" not in said


def test_a_reading_that_is_missing_has_no_line(wheel):
    bare = WheelDocument(
        source="a", sensor="", profile=wheel.profile, flange_height=wheel.flange_height
    )
    root = drawn(bare)
    assert len(named(root, "line", "gauge")) == 1
    assert words(root).count("missing") == 6


def test_wheels_are_drawn_one_below_the_other_or_in_files_of_their_own(tmp_path, wheel):
    unmeasured = wheel.model_copy(update={"profile": None, "reason": "too <dark>"})
    root = drawn(wheel, unmeasured, wheel)
    assert len(named(root, "polyline", "wear-line")) == 2
    assert "not measured: too <dark>" in words(root)
    heights = [float(line.get("y1")) for line in named(root, "line", "datum")]
    assert max(heights) > 2.0 * float(root.get("height")) / 3.0
    paths = write_plots(tmp_path / "drawings", [wheel, unmeasured, wheel], S1002)
    assert [path.name for path in paths] == ["a.svg", "a-2.svg"]
    (one,) = write_plots(tmp_path / "all.svg", [wheel, wheel], S1002)
    assert len(named(ET.parse(one).getroot(), "polyline", "wear-line")) == 2


def test_everything_is_inside_the_drawing_however_far_the_back_face_reaches(tmp_path):
    path = miniprof_file(tmp_path / "deep.whl", back_face_mm=60.0)
    root = drawn(*gauge_files([path]).wheels)
    _, _, width, height = map(float, root.get("viewBox").split())
    (measured,) = named(root, "polyline", "measured")
    frame = named(root, "rect", "frame")[0]
    foot = float(frame.get("y")) + float(frame.get("height"))
    assert points(measured)[:, 1].max() <= foot + 0.1
    for kind in ("polyline", "polygon"):
        for each in root.iter(f"{SVG}{kind}"):
            x, y = points(each).T
            assert 0.0 <= x.min() <= x.max() <= width
            assert 0.0 <= y.min() <= y.max() <= height


def test_name_of_a_source_is_never_markup(wheel):
    named_so = wheel.model_copy(update={"source": "<script>&", "frame": 3})
    text = profile_svg([named_so], S1002)
    assert "<script>" not in text
    assert re.search("&lt;script&gt;&amp; frame 3 over S1002", text)


def test_a_chamfer_does_not_set_the_scale_of_the_wear(tmp_path):
    shape = profile(worn_mm=0.5)
    chamfered = shape.h_mm - 9.0 * np.clip((shape.d_mm - 121.0) / 9.0, 0.0, 1.0)
    path = tmp_path / "a.csv"
    rows = zip(shape.d_mm, chamfered, strict=True)
    path.write_text("d,h\n" + "".join(f"{d:.4f},{h:.4f}\n" for d, h in rows))
    root = drawn(*gauge_files([path]).wheels)
    (line,) = named(root, "polyline", "wear-line")
    wear_frame = named(root, "rect", "frame")[1]
    top, height = float(wear_frame.get("y")), float(wear_frame.get("height"))
    y = points(line)[:, 1]
    assert top <= y.min() <= y.max() <= top + height
    # Half a millimetre is drawn over more than a third of the field.
    assert np.ptp(y) > height / 3.0
