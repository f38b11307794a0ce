"""What is exported as MiniProf is read back: the same points, the same figures, the same wheel."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from profile_files import miniprof_file

from measure import Quantity, Side
from station.exports import write_miniprof
from station.pipeline import gauge_files, read_profile

HEADER = {"WheelID": "4711", "CarNo": "9", "AxleNo": "3", "Side": "R", "Window": "x"}


def gauged(tmp_path, *names, header=None, **shape):
    return gauge_files([miniprof_file(tmp_path / name, header, **shape) for name in names])


def test_a_file_reads_back_as_the_wheel_it_was(tmp_path):
    document = gauged(tmp_path, "a.whl", header=HEADER, worn_mm=2.0)
    (path,) = write_miniprof(tmp_path / "out.whl", document)
    text = path.read_bytes()
    assert text.isascii()
    assert b"Units=mm\n" in text
    again = gauge_files([path]).wheels[0]
    first = document.wheels[0]
    for quantity, reading in first.readings.items():
        # Points rounded to 0.1 um; heights of the two files differ by where their zero is.
        assert again.readings[quantity].value == pytest.approx(reading.value, abs=1e-3)
    kept = {key: again.header.fields.get(key) for key in HEADER}
    assert kept == {**HEADER, "Window": None}
    for quantity, said in again.header.claimed.items():
        assert said == pytest.approx(first.readings[quantity].value, abs=5.1e-5)
    assert len(again.header.claimed) == 3


@given(
    worn_mm=st.floats(0.0, 8.0),
    step_mm=st.floats(0.15, 0.5),
    name=st.text(st.characters(codec="latin-1", exclude_characters="=\r\n\x85"), max_size=12),
    side=st.sampled_from(Side),
    axle=st.integers(1, 900),
)
@settings(
    max_examples=15, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
def test_whatever_is_written_can_be_read(tmp_path, worn_mm, step_mm, name, side, axle):
    document = gauged(tmp_path, "a.whl", worn_mm=worn_mm, step_mm=step_mm)
    (wheel,) = document.wheels
    known = wheel.model_copy(update={"wheelset": name, "side": side, "axle": axle})
    (path,) = write_miniprof(tmp_path / "out.whl", document.model_copy(update={"wheels": (known,)}))
    file = read_profile(path)
    # Four decimals.
    np.testing.assert_allclose(file.profile.d_mm, wheel.profile.d_mm, atol=5.1e-5)
    np.testing.assert_allclose(file.profile.h_mm, wheel.profile.h_mm, atol=5.1e-5)
    assert file.header["Side"] == {"left": "L", "right": "R"}[side]
    assert file.header["AxleNo"] == str(axle)
    assert set(file.claimed) == {
        Quantity.FLANGE_HEIGHT,
        Quantity.FLANGE_THICKNESS_10,
        Quantity.FLANGE_GRADIENT_QR,
    }


def test_where_the_figures_were_taken_is_said_again_in_millimetres(tmp_path):
    inches = miniprof_file(tmp_path / "a.whl", {"Line": "5"})
    table = [line.split() for line in inches.read_text().split("\n\n")[1].splitlines()]
    rows = "\n".join(" ".join(f"{float(value) / 25.4:.6f}" for value in row) for row in table)
    inches.write_text(f"Units=inch\nL2=2.9\n\n{rows}\n")
    (path,) = write_miniprof(tmp_path / "out.whl", gauge_files([inches]))
    assert read_profile(path).header["L2"] == "73.66"


def test_several_wheels_are_numbered_or_go_into_a_folder(tmp_path):
    part = miniprof_file(tmp_path / "part.whl", to_d_mm=60.0)
    files = [miniprof_file(tmp_path / name) for name in ("a.whl", "b.whl")]
    document = gauge_files([files[0], part, files[1]])
    numbered = write_miniprof(tmp_path / "w.mp", document)
    assert [path.name for path in numbered] == ["w-1.mp", "w-2.mp"]
    in_folder = write_miniprof(tmp_path / "out", document)
    assert [path.relative_to(tmp_path).as_posix() for path in in_folder] == [
        "out/a.whl",
        "out/b.whl",
    ]


def test_names_of_sources_never_leave_the_folder(tmp_path):
    document = gauged(tmp_path, "a.whl")
    names = ("../../etc/x.mcap", "..", "a.png", "A.png", "\u00e4 b/c.png")
    wheels = tuple(document.wheels[0].model_copy(update={"source": name}) for name in names)
    paths = write_miniprof(tmp_path / "out", document.model_copy(update={"wheels": wheels}))
    assert len({path.name.lower() for path in paths}) == len(names)
    assert {path.parent for path in paths} == {tmp_path / "out"}
    assert all(path.is_file() for path in paths)
