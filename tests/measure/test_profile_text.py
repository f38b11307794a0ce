"""Profiles as text: what MiniProf and tables say is read, what they do not say is refused."""

import numpy as np
import pytest

from measure import (
    ProfileTextInvalid,
    Quantity,
    format_miniprof,
    gauge_profile,
    parse_miniprof,
    parse_profile_csv,
    parse_profile_text,
    reference_profile,
)

S1002 = reference_profile("S1002")
D, H = (S1002.points(0.4, back_face_mm=20.0) + [70.0, 0.0]).T


def rows(d, h, form="{:.4f} {:.4f}"):
    return "\n".join(form.format(*row) for row in zip(d, h, strict=True)) + "\n"


def keyword_file(d=D, h=H, **fields):
    head = {"ColumnDef": "X,Y", "XYPoints": len(d), **fields}
    return "\n".join(f"{key}={value}" for key, value in head.items()) + "\n\n" + rows(d, h)


def read(profile):
    answer = gauge_profile(profile, S1002)
    assert answer.reason is None
    return {q: r.value for q, r in answer.readings.items()}


@pytest.mark.parametrize(
    "text",
    [
        keyword_file(),
        keyword_file(D[::-1], H[::-1]),
        keyword_file(D, -H),
        keyword_file(-D, H),
        keyword_file().replace("\n", "\r\n"),
        "#MINIWHEELPROF\nname\nWheel ID....:\n\" 32.58 37.11 14.71\n(Sd/Sh/qR)\n\n" + rows(D, H),
        "MINIPROF 101 148\nname\n32.58 37.11 14.71  (Sd/Sh/qR)\n\n"
        + rows(D, H, "{:.4f} {:.4f} 0.000"),
        "d_mm,h_mm\n" + rows(D, H, "{:.4f},{:.4f}"),
        "y;z\n" + rows(D - 70.0, H, "{:.4f};{:.4f}").replace(".", ","),
        "# a table\n" + rows(D - 70.0, H, "{:.4f}\t{:.4f}"),
        "no,z,y\n" + rows(H, D - 70.0, "0,{:.4f},{:.4f}"),
    ],
    ids=[
        "keywords", "rows reversed", "height down", "to the left", "CRLF", "old with #", "old",
        "CSV", "decimal comma", "tabs around the tape", "columns by name",
    ],
)  # fmt: skip
def test_every_form_of_a_profile_reads_the_same(text):
    values = read(parse_profile_text(text))
    for quantity, nominal in S1002.nominal.items():
        # Points of 0.4 mm rounded to 0.1 um, averaged over 1.3 mm.
        assert values[quantity] == pytest.approx(nominal, abs=3e-3)


def test_what_the_header_claims_is_told_apart_from_what_is_measured():
    file = parse_miniprof(keyword_file(Sd=33.1, Sh="28.2", qR="", WheelID="4711"))
    assert file.claimed == {Quantity.FLANGE_THICKNESS_10: 33.1, Quantity.FLANGE_HEIGHT: 28.2}
    assert file.header["WheelID"] == "4711"
    assert read(file.profile)[Quantity.FLANGE_HEIGHT] == pytest.approx(28.0, abs=1e-3)


def test_a_written_file_reads_back_the_same():
    profile = parse_miniprof(keyword_file()).profile
    again = parse_miniprof(format_miniprof(profile, {"Sd": "32.5", "Side": "L"}))
    np.testing.assert_allclose(again.profile.points_mm, profile.points_mm, atol=5e-5)
    assert again.header["Side"] == "L"


@pytest.mark.parametrize("header", [{"Car=No": "1"}, {"Note": "two\nlines"}, {"": "x"}])
def test_a_header_that_would_break_the_file_is_refused(header):
    with pytest.raises(ProfileTextInvalid, match="one line"):
        format_miniprof(parse_miniprof(keyword_file()).profile, header)


@pytest.mark.parametrize(
    ("parse", "text", "match"),
    [
        (parse_miniprof, "", "no rows"),
        (parse_miniprof, "Sd=1\n\nhello\n", "no rows"),
        (parse_miniprof, keyword_file(XYPoints=9999), "cut or damaged"),
        (parse_miniprof, keyword_file(ColumnDef="A,B"), "no X and Y"),
        (parse_miniprof, keyword_file(D[:10], H[:10]), "20 or more"),
        (parse_miniprof, keyword_file(D, 0.0 * H), "no flange"),
        (parse_miniprof, keyword_file(D[D < 60.0], H[D < 60.0]), "beyond 70"),
        (parse_profile_csv, "", "no rows"),
        (parse_profile_csv, "a,b\n1,2\n", "no d"),
        (parse_profile_csv, "d,b\n1,2\n", "no h or z"),
        (parse_profile_csv, "d,h\n1,2\n3,nan\n", "row 3"),
        (parse_profile_csv, "d,h\n1,2\nx,y\n", "row 3"),
    ],
)
def test_what_is_no_profile_is_refused_in_one_line(parse, text, match):
    with pytest.raises(ProfileTextInvalid, match=match) as refusal:
        parse(text)
    assert "\n" not in str(refusal.value)


def test_a_profile_without_a_tread_gives_a_reason():
    profile = parse_miniprof(keyword_file()).profile
    short = type(profile)(D[D < 60.0], H[D < 60.0], np.zeros(np.sum(D < 60.0)))
    answer = gauge_profile(short, S1002)
    assert "half a wheel" in answer.reason
    assert all(reading.value is None for reading in answer.readings.values())


def test_scatter_of_the_points_is_in_the_interval(rng):
    noisy = parse_miniprof(keyword_file(D, H + rng.normal(0.0, 0.02, len(H)))).profile
    reading = gauge_profile(noisy, S1002).readings[Quantity.FLANGE_HEIGHT]
    # Parabolas over 7 points each for tip and tread: 0.02 x sqrt(2) x 1.5 / sqrt(7), twice.
    assert 0.015 < reading.u95 < 0.06
    assert abs(reading.value - 28.0) < 2.0 * reading.u95
