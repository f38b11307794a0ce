"""Profiles as text: what MiniProf and tables say is read, what they do not say is refused.

Files of real instruments are not among these: what they read is tried by hand.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from measure import (
    OF_A_PROFILE,
    GaugeLevels,
    Profile,
    ProfileTextInvalid,
    Quantity,
    Status,
    format_miniprof,
    gauge_profile,
    parse_miniprof,
    parse_profile_csv,
    parse_profile_text,
    reference_profile,
)
from measure.profiles.orientation import oriented

S1002 = reference_profile("S1002")
D, H = (S1002.points(0.4, back_face_mm=20.0) + [70.0, 0.0]).T


# The head of a rail: as wide as a flange is high, and level in the middle.
RAIL_X = np.linspace(-36.0, 36.0, 200)
RAIL_Y = 300.0 - (RAIL_X / 36.0) ** 8 * 30.0 - RAIL_X**2 / 600.0


def rows(d, h, form="{:.4f} {:.4f}"):
    return "\n".join(form.format(*row) for row in zip(d, h, strict=True)) + "\n"


def keyword_file(d=D, h=H, **fields):
    head = {"ColumnDef": "X,Y", "XYPoints": len(d), **fields}
    return "\n".join(f"{key}={value}" for key, value in head.items()) + "\n\n" + rows(d, h)


def read(profile):
    answer = gauge_profile(profile, S1002)
    assert answer.reason is None
    return {q: r.value for q, r in answer.readings.items()}


def shuffled(text):
    head, _, body = text.partition("\n\n")
    lines = body.splitlines()
    return head + "\n\n" + "\n".join(np.random.default_rng(7).permutation(lines)) + "\n"


OLD = 'name\nWheel ID....:\n" 32.58 37.11 14.71\n(Sd/Sh/qR)\n\n'
KEYWORDS = keyword_file()
FORMS = {
    "keywords": KEYWORDS,
    "rows reversed": keyword_file(D[::-1], H[::-1]),
    "rows shuffled": shuffled(KEYWORDS),
    "rows shuffled, to the left, height down": shuffled(keyword_file(-D, -H)),
    "height down": keyword_file(D, -H),
    "to the left": keyword_file(-D, H),
    "to the left, rows reversed, height down": keyword_file(-D[::-1], -H[::-1]),
    "around the tape": keyword_file(D - 70.0, H),
    "around the tape to the left": keyword_file(70.0 - D, H),
    "height over the axle": keyword_file(D, H + 420.0),
    "CRLF": KEYWORDS.replace("\n", "\r\n"),
    "byte order mark": "\ufeff" + KEYWORDS,
    "keys in capitals": KEYWORDS.replace("ColumnDef", "COLUMNDEF").replace("XYPoints", "XYPOINTS"),
    "no blank line": KEYWORDS.replace("\n\n", "\n"),
    "blank lines in the header": "\n\n" + KEYWORDS.replace("XYPoints", "\nNote=1 2\n\nXYPoints"),
    "old without blank line": "MINIPROF 2.0\nname\n1 2 3\n(Sd/Sh/qR)\n" + rows(D, H),
    "comments between": KEYWORDS.replace("\n0.", "\n! a note 1 2\n0.", 3),
    "decimal comma, blanks": KEYWORDS.replace(".", ","),
    "decimal comma, tabs": keyword_file().replace(" ", "\t").replace(".", ","),
    "commas between": "A=1\n\n" + rows(D, H, "{:.4f}, {:.4f}"),
    "columns by ColumnDef": "ColumnDef=N,Y,A,C,X\n\n" + rows(D, H, "7 {1:.4f} 0.1 0.2 {0:.4f}"),
    "inches": "Units=inch\nColumnDef=X,Y\n\n" + rows(D / 25.4, H / 25.4, "{:.6f} {:.6f}"),
    "millimetres said": "Unit=mm\n\n" + rows(D, H),
    "the unit is a train's": "Unit=4711\n\n" + rows(D, H),
    "old with #": "#MINIWHEELPROF\n" + OLD + rows(D, H),
    "old": "MINIPROF 101 148\n" + OLD + rows(D, H, "{:.4f} {:.4f} 0.000"),
    "CSV": "d_mm,h_mm\n" + rows(D, H, "{:.4f},{:.4f}"),
    "CSV with units": "d [mm];h [mm]\n" + rows(D, H, "{:.4f};{:.4f}"),
    "CSV, decimal comma": "y;z\n" + rows(D - 70.0, H, "{:.4f};{:.4f}").replace(".", ","),
    "CSV, x and y": "x,y\n" + rows(D, -H, "{:.4f},{:.4f}"),
    "tabs around the tape": "# a table\n" + rows(D - 70.0, H, "{:.4f}\t{:.4f}"),
    "columns by name": "no,z,y\n" + rows(H, D - 70.0, "0,{:.4f},{:.4f}"),
}


@pytest.mark.parametrize("text", FORMS.values(), ids=FORMS)
def test_every_form_of_a_profile_reads_the_same(text):
    values = read(parse_profile_text(text).profile)
    for quantity, nominal in S1002.nominal.items():
        # Points of 0.4 mm rounded to 0.1 um, averaged over 1.3 mm.
        assert values[quantity] == pytest.approx(nominal, abs=3e-3)


@given(
    side=st.sampled_from((1.0, -1.0)),
    up=st.sampled_from((1.0, -1.0)),
    around_tape=st.booleans(),
    order=st.randoms(use_true_random=False),
    foot_mm=st.floats(0.0, 45.0),
)
@settings(max_examples=30, deadline=None)
def test_a_profile_is_laid_right_from_any_order_and_either_sign(
    side, up, around_tape, order, foot_mm
):
    points = S1002.points(0.4, back_face_mm=foot_mm) + [0.0 if around_tape else 70.0, 0.0]
    rows_mm = list(range(len(points)))
    order.shuffle(rows_mm)
    found = oriented(points[rows_mm] * [side, up])
    truth = S1002.points(0.4, back_face_mm=foot_mm) + [70.0, 0.0]
    np.testing.assert_allclose(found.points_mm, truth, atol=1e-9)


def test_what_the_header_claims_is_told_apart_from_what_is_measured():
    file = parse_miniprof(keyword_file(SD=33.1, Sh="28,2", qR="", WheelID="4711"))
    assert file.claimed == {Quantity.FLANGE_THICKNESS_10: 33.1, Quantity.FLANGE_HEIGHT: 28.2}
    assert file.header["WheelID"] == "4711"
    assert read(file.profile)[Quantity.FLANGE_HEIGHT] == pytest.approx(28.0, abs=1e-3)


@pytest.mark.parametrize("before", ["\n(", "  (", "\n"])
def test_figures_of_an_old_file_are_read_by_the_names_behind_them(before):
    head = OLD.replace("\n(", before)
    claimed = parse_miniprof("#MINIWHEELPROF\n" + head + rows(D, H)).claimed
    assert claimed == {
        Quantity.FLANGE_THICKNESS_10: 32.58,
        Quantity.FLANGE_HEIGHT: 37.11,
        Quantity.FLANGE_GRADIENT_QR: 14.71,
    }


def test_figures_in_inches_are_claimed_in_millimetres():
    text = "Units=inches\nSh=1.1\nL2=2.9\n\n" + rows(D / 25.4, H / 25.4, "{:.6f} {:.6f}")
    file = parse_miniprof(text)
    assert file.claimed[Quantity.FLANGE_HEIGHT] == pytest.approx(27.94)
    assert file.levels.tape_d_mm == pytest.approx(73.66)


def test_gauges_touch_where_the_header_says():
    file = parse_miniprof(keyword_file(L1="3", L2="73.5", L3="0"))
    assert file.levels == GaugeLevels(tape_d_mm=73.5, face_mm=10.0, below_tip_mm=3.0)
    answer = gauge_profile(file.profile, S1002, levels=file.levels)
    height = answer.readings[Quantity.FLANGE_HEIGHT].value
    assert height == pytest.approx(28.0 - S1002.height_mm(3.5), abs=1e-3)
    # Wear counts from the same place of the reference: a new wheel has none, wherever it is.
    for quantity in (Quantity.TREAD_WEAR, Quantity.TREAD_WEAR_AT_70):
        assert answer.readings[quantity].value == pytest.approx(0.0, abs=1e-3)


plain_text = st.text(st.characters(min_codepoint=32, max_codepoint=126, exclude_characters="="))


@given(header=st.dictionaries(plain_text.filter(str.strip), plain_text, max_size=5))
@settings(max_examples=50, deadline=None)
def test_a_written_file_reads_back_the_same(header):
    profile = parse_miniprof(keyword_file()).profile
    reserved = {"units", "columndef", "xypoints", "sh", "sd", "qr", "l1", "l2", "l3"}
    kept = {
        key: value
        for key, value in header.items()
        if key.strip().lower() not in reserved and "unit" not in key.lower()
    }
    text = format_miniprof(profile, {"Sd": "32.5", "Side": "L", **kept})
    assert text.isascii()
    again = parse_miniprof(text)
    np.testing.assert_allclose(again.profile.points_mm, profile.points_mm, atol=5.1e-5)
    assert again.claimed == {Quantity.FLANGE_THICKNESS_10: 32.5}
    for key, value in kept.items():
        assert again.header[key.strip()] in {v.strip() for v in kept.values()}, value
    assert again.header["Units"] == "mm"


@pytest.mark.parametrize(
    "header", [{"Car=No": "1"}, {"Note": "two\nlines"}, {"": "x"}, {"Line": "K\u00f6ln"}]
)
def test_a_header_that_would_break_the_file_is_refused(header):
    with pytest.raises(ProfileTextInvalid, match="one line|ASCII"):
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
        (parse_miniprof, keyword_file(D[D < 25.0], H[D < 25.0]), "highest place|no flange"),
        (parse_miniprof, keyword_file(D / 25.4, H / 25.4), "Units=inch"),
        (parse_miniprof, keyword_file(RAIL_X, RAIL_Y), "highest place"),
        (parse_miniprof, keyword_file(D + 40.0, H), "4 to 40 from the flange back"),
        (parse_miniprof, keyword_file(L2="7"), "50 to 100"),
        (parse_miniprof, keyword_file(Units="cm"), "mm and inch"),
        (parse_profile_csv, "d,h\n" + "1,2\n" * 30, "no flange"),
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


def part(keep):
    return Profile(D[keep], H[keep], np.zeros(keep.sum()))


@pytest.mark.parametrize(
    ("keep", "match"),
    [
        (D < 60.0, "half a wheel"),
        (D > 35.0, "no flange"),
        ((D > 30.0) & (D < 40.0), "50 needed"),
    ],
    ids=["no tread", "no flange", "few points"],
)
def test_a_part_of_a_wheel_gives_a_reason_and_no_value(keep, match):
    answer = gauge_profile(part(keep), S1002)
    assert match in answer.reason
    assert "\n" not in answer.reason
    assert all(reading.value is None for reading in answer.readings.values())


def test_without_a_flange_back_height_is_read_and_thickness_only_where_allowed():
    seen = gauge_profile(part(D > 3.0), S1002).readings
    for needs in ("flange_thickness_10", "flange_thickness_12", "flange_gradient_qr"):
        assert seen[Quantity(needs)].status is Status.MISSING
    height = seen[Quantity.FLANGE_HEIGHT]
    assert height.status is Status.REFERENCE_ASSUMED
    assert height.value == pytest.approx(28.0, abs=3e-3)
    # A tape circle known to 0.5 mm, on a tread that falls by 1 in 30 there.
    assert 0.02 < height.u95 < 0.06
    answer = gauge_profile(part(D > 3.0), S1002, assume_back=True)
    seen = answer.readings
    read = [reading.status for quantity, reading in seen.items() if quantity in OF_A_PROFILE]
    assert set(read) == {Status.REFERENCE_ASSUMED}
    assert seen[Quantity.FLANGE_THICKNESS_10].value == pytest.approx(32.5, abs=3e-3)


def test_a_flange_back_far_off_its_place_gives_a_reason():
    for shift_mm in (-1.5, 1.5):
        answer = gauge_profile(Profile(D + shift_mm, H, np.zeros(len(D))), S1002)
        assert "1.5 mm off d = 0" in answer.reason


def test_how_far_the_flange_back_lies_off_its_place_is_in_the_interval():
    shifted = gauge_profile(Profile(D - 0.2, H, np.zeros(len(D))), S1002).readings
    # A place within 0.2 mm, evenly likely: 1.96 x 0.2 / sqrt(3); a tread of 1 in 30 makes 8 um
    # of it.
    thickness = shifted[Quantity.FLANGE_THICKNESS_10]
    assert thickness.u95 == pytest.approx(0.226, abs=0.01)
    assert abs(thickness.value - 32.5) < thickness.u95
    assert shifted[Quantity.FLANGE_HEIGHT].u95 < 0.012


def test_a_profile_is_returned_with_its_tip_as_high_as_the_references():
    worn = gauge_profile(Profile(D, H + 3.0, np.zeros(len(D))), reference_profile("LMA")).profile
    assert worn.h_mm.max() == pytest.approx(28.0, abs=2e-3)


def test_wear_of_a_profile_is_what_is_missing_below_the_reference():
    lowered = np.where(D > 50.0, H - 0.5, H)
    wear = Profile(D, lowered, np.zeros(len(D))).wear_mm(S1002)
    assert np.isnan(wear[D < 14.5]).all()
    np.testing.assert_allclose(wear[D > 50.0], 0.5, atol=1e-9)


def test_a_chamfer_beside_the_tread_is_no_wear_of_it():
    bump = 0.4 * np.exp(-0.5 * ((D - 90.0) / 12.0) ** 2)
    chamfered = H - bump - 9.0 * np.clip((D - 119.0) / 9.0, 0.0, 1.0)
    answer = gauge_profile(Profile(D, chamfered, np.zeros(len(D))), S1002)
    assert answer.quality.wear_max_at_d_mm == pytest.approx(90.0, abs=2.0)
    assert answer.readings[Quantity.TREAD_WEAR_MAX].value == pytest.approx(0.4, abs=0.01)


def test_points_that_lie_too_far_apart_give_a_reason():
    d, h = (S1002.points(2.5, back_face_mm=20.0) + [70.0, 0.0]).T
    assert "2.5 mm apart" in gauge_profile(Profile(d, h, np.zeros(len(d))), S1002).reason


@pytest.mark.parametrize("step_mm", [0.1, 0.5, 1.0, 1.5])
def test_readings_do_not_depend_on_how_dense_the_points_are(step_mm):
    d, h = (S1002.points(step_mm, back_face_mm=20.0) + [70.0, 0.0]).T
    answer = gauge_profile(Profile(d, h, np.zeros(len(d))), S1002)
    for quantity, nominal in S1002.nominal.items():
        # Seven points in a parabola: from 1 mm on it spans joints of arcs that it cannot follow.
        reading = answer.readings[quantity]
        assert reading.value == pytest.approx(nominal, abs=4e-3 if step_mm < 1.0 else 0.02)
        assert abs(reading.value - nominal) < reading.u95 + 1e-3


def test_two_strokes_of_a_probe_that_do_not_meet_are_in_the_interval():
    at_tip = (D > 15.5) & (D < 17.5)
    broken = H - 0.3 * (D > 15.5) + 0.3 * (D > 17.5) * np.clip((D - 17.5) / 10.0, 0.0, 1.0)
    assert at_tip.any()
    clean, torn = (
        gauge_profile(Profile(D, h, np.zeros(len(D))), S1002).readings for h in (H, broken)
    )
    height = torn[Quantity.FLANGE_HEIGHT]
    assert clean[Quantity.FLANGE_HEIGHT].u95 < 0.01
    assert abs(height.value - 28.0) < height.u95
    assert torn[Quantity.FLANGE_THICKNESS_12].u95 < 0.3


def test_scatter_of_the_points_is_in_the_interval(rng):
    noisy = parse_miniprof(keyword_file(D, H + rng.normal(0.0, 0.02, len(H)))).profile
    reading = gauge_profile(noisy, S1002).readings[Quantity.FLANGE_HEIGHT]
    # Parabolas over 7 points each for tip and tread: 0.02 x sqrt(2) x 1.5 / sqrt(7), twice.
    assert 0.015 < reading.u95 < 0.06
    assert abs(reading.value - 28.0) < 2.0 * reading.u95
