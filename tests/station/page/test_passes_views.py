"""What the pages of passes show, without a station: the search, marks, drawings and trends."""

import re
from datetime import UTC, date, datetime, timedelta
from urllib.parse import parse_qsl, urlsplit
from zoneinfo import ZoneInfo

import numpy as np
import pytest
from newest_schema import make_store
from profile_files import S1002, miniprof_file

from measure import Alarm, Limit, Limits, Quantity, Rate, Side, Status
from station.errors import InputUnusable, NotFound
from station.page.passes.list_view import pass_list
from station.page.passes.marks import Mark, mark_of
from station.page.passes.paths import path_of
from station.page.passes.profile_drawing import profile_drawing, reference_named
from station.page.passes.search import Search
from station.page.passes.trend_view import Trended
from station.page.texts import Texts
from station.pipeline import gauge_files
from station.store import Pass, PassState, Store, sqlite_url
from station.store.lists import Span
from station.trains import QuantityTrend, SideTrend, TrendValue, WheelsetTrend

BERLIN = ZoneInfo("Europe/Berlin")
NOON = datetime(2026, 7, 1, 12, tzinfo=UTC)


def test_an_empty_form_asks_for_nothing():
    search = Search.model_validate({"id": "", "state": "", "from": "", "to": "", "before": ""})
    assert not search.asks
    assert search.address == "/passes"
    assert search.span(BERLIN) == Span()


def test_the_address_holds_the_search_but_not_the_page():
    asked = {"train": "Müller & <b>", "from": "2026-03-28", "before": "2026-07-01T12:00:00+00:00 p"}
    search = Search.model_validate(asked)
    assert search.address == "/passes?from=2026-03-28&train=M%C3%BCller+%26+%3Cb%3E"
    assert "before=" in search.older("2026-07-01T12:00:00+00:00 p")


def test_days_begin_and_end_in_the_zone_of_the_station():
    # Summer time began that day: it had 23 hours.
    day = date(2026, 3, 29)
    span = Search.model_validate({"from": day, "to": day}).span(BERLIN)
    assert span.since == datetime(2026, 3, 28, 23, tzinfo=UTC)
    assert span.until == datetime(2026, 3, 29, 22, tzinfo=UTC)


def test_days_that_run_backwards_are_refused():
    search = Search.model_validate({"from": "2026-03-02", "to": "2026-03-01"})
    with pytest.raises(InputUnusable, match="the last day comes before the first"):
        search.span(BERLIN)


@pytest.mark.parametrize(
    ("seen", "measured", "levels", "mark"),
    [
        (True, True, [], Mark.FINE),
        (True, True, [Alarm.WARNING], Mark.WARNING),
        (True, True, [Alarm.WARNING, Alarm.ALARM], Mark.ALARM),
        (True, False, [], Mark.UNMEASURED),
        (False, False, [], Mark.UNSEEN),
    ],
)
def test_a_wheel_bears_the_gravest_mark(seen, measured, levels, mark):
    assert mark_of(seen=seen, measured=measured, levels=levels) is mark


def test_no_two_marks_look_alike():
    assert len({mark.sign for mark in Mark}) == len(Mark)
    assert {f"passes.mark.{mark}" for mark in Mark} <= set(Texts.of())


@pytest.fixture
def wheel(tmp_path):
    return gauge_files([miniprof_file(tmp_path / "a.whl", {"Sh": "29.1"}, worn_mm=1.0)]).wheels[0]


def places(path):
    """Return the places of a path in mm, heights upwards."""
    start, _, steps = path.removeprefix("M").removesuffix("z").partition("l")
    moves = [start, *steps.split()]
    um = np.cumsum([[int(number) for number in move.split(",")] for move in moves], axis=0)
    return um / [1000.0, -1000.0]


def test_rounding_does_not_add_up_along_a_path():
    points = np.cumsum(np.random.default_rng(7).normal(scale=0.05, size=(2000, 2)), axis=0)
    # Half a micrometre, as each place is rounded by itself.
    np.testing.assert_allclose(places(path_of(points)), points, atol=0.0005001)


def test_a_drawing_shows_the_profile_where_it_was_measured(wheel):
    drawing = profile_drawing(7, wheel, S1002, "S1002")
    (strand,) = drawing["strands"]
    measured = wheel.profile.profile()
    np.testing.assert_allclose(places(strand["path"]), measured.points_mm, atol=0.0005001)
    assert [each["quantity"] for each in drawing["gauges"]] == [
        "flange_height",
        "flange_thickness_12",
        "flange_thickness_10",
        "flange_gradient_qr",
    ]
    sh = drawing["gauges"][0]
    assert abs(sh["ends"][1][1] - sh["ends"][0][1]) == pytest.approx(wheel.flange_height.value)
    assert drawing["wear"]["wear_mm"][len(drawing["wear"]["wear_mm"]) // 2] == pytest.approx(
        1.0, abs=0.05
    )
    assert len(drawing["wear"]["d_mm"]) <= 400


def test_a_wheel_whose_reference_is_gone_is_drawn_alone(wheel):
    drawing = profile_drawing(7, wheel, None, "our-new-wheel")
    assert drawing["reference"] == {"name": "our-new-wheel", "path": None}
    assert drawing["wear"] is None
    assert drawing["lost"] == ""
    assert drawing["strands"][0]["path"].startswith("M")


def test_a_wheel_without_a_profile_says_why(wheel):
    bare = wheel.model_copy(update={"profile": None, "reason": "no stripe"})
    with pytest.raises(NotFound, match="no profile: no stripe"):
        profile_drawing(7, bare, S1002, "S1002")


def test_references_are_the_analytic_ones_and_the_own_of_the_station(tmp_path):
    own = miniprof_file(tmp_path / "new-wheel.whl")
    assert reference_named("LMA", "S1002").name == "LMA"
    assert reference_named("new-wheel", str(own)).name == "new-wheel"
    assert reference_named("another", str(own)) is None
    assert reference_named("another", str(tmp_path / "gone.whl")) is None


def trend_of(*values, **more):
    return QuantityTrend(tuple(values), len(values), None, more.get("per_pass"), None)


def value(day, mm, *, calibration="c1", jump=None):
    at = NOON + timedelta(days=day)
    return TrendValue(
        pass_id=f"p{day}",
        at=at,
        measurement_id=day,
        calibration_id=calibration,
        value=mm,
        u95=0.1,
        status=Status.OK,
        alarm=Alarm.NONE,
        jump=jump,
    )


def chart_of(quantity, limit, **sides):
    found = tuple(
        SideTrend(Side(side), len(trend.values), {quantity: trend}) for side, trend in sides.items()
    )
    limits = Limits("test", {} if limit is None else {quantity: limit})
    return Trended.of(WheelsetTrend("w1", found), quantity, limits).chart(Texts.of())


def test_a_trend_has_a_place_for_each_pass_and_none_where_a_side_was_not_measured():
    left = trend_of(value(1, 4.0), value(3, 4.2), per_pass=Rate(0.2, 0.05))
    chart = chart_of(Quantity.TREAD_WEAR, None, left=left, right=trend_of(value(2, 3.0)))
    assert len(chart["x"]) == 3
    assert [each["values"] for each in chart["series"]] == [[4.0, None, 4.2], [None, 3.0, None]]
    assert chart["series"][0]["u95"] == [0.1, None, 0.1]
    assert chart["series"][0]["measurements"] == [1, None, 3]
    assert re.search(r"Left: 0.200.mm ± 0.050.mm a pass, from 2 passes", chart["rates"][0])


def test_warnings_lie_before_the_end_that_wear_leads_to():
    both = Limit(22.0, 33.0, warn_within_mm=1.0)
    thins = chart_of(Quantity.FLANGE_THICKNESS_10, both, left=trend_of(value(1, 30.0)))
    grows = chart_of(Quantity.FLANGE_HEIGHT, both, left=trend_of(value(1, 30.0)))
    assert {"from": 22.0, "to": 23.0, "colour": "--warn"} in thins["spans"]
    assert {"from": 32.0, "to": 33.0, "colour": "--warn"} in grows["spans"]
    assert [level["value"] for level in thins["levels"]] == [22.0, 33.0]


def test_other_calibrations_and_jumps_are_marked_where_they_came():
    values = [value(1, 4.0), value(2, 4.1), value(3, 7.0, calibration="c2", jump=2.9)]
    chart = chart_of(Quantity.TREAD_WEAR, None, left=trend_of(*values))
    third = values[2].at.timestamp()
    assert [(each["x"], each["label"]) for each in chart["moments"]] == [
        (third, "Left: other calibration"),
        (third, "Left: jump"),
    ]


def test_older_passes_are_at_the_address_of_the_page_before(tmp_path):
    url = sqlite_url(tmp_path / "station.sqlite")
    make_store(url)
    store = Store.open(url)
    names = [f"p{number}" for number in range(101)]
    with store.change() as session:
        for number, name in enumerate(names):
            at = NOON + timedelta(minutes=number)
            session.add(Pass(id=name, state=PassState.FAILED, opened_at=at))
    search, seen, pages = Search.model_validate({"id": "p"}), [], 0
    with store.look() as session:
        while search is not None:
            found = pass_list(session, search, None)
            seen += [row.id for row in found.rows]
            pages += 1
            asked = None if found.older is None else dict(parse_qsl(urlsplit(found.older).query))
            search = None if asked is None else Search.model_validate(asked)
    store.close()
    assert seen == names[::-1]
    assert pages == 3
