"""Shows which pictures of several sensors are taken for one showing of a target."""

from pathlib import Path

import pytest

from station.errors import InputUnusable
from station.pipeline.rig_sources import sources_by_sensor
from station.pipeline.showings import SeenPose, missing_in, showings_of

SECOND_NS = 1_000_000_000


def poses(*names, times_s=None):
    times = [None] * len(names) if times_s is None else [round(t * SECOND_NS) for t in times_s]
    return [SeenPose(name, "dark", time) for name, time in zip(names, times, strict=True)]


def names_of(showings):
    return [{sensor: pose.name for sensor, pose in showing.items()} for _, showing in showings]


def test_pictures_pair_by_order_where_nothing_else_tells():
    found = showings_of({"inner": poses("a1.png", "a2.png"), "outer": poses("b1.png", "b2.png")})
    assert names_of(found) == [
        {"inner": "a1.png", "outer": "b1.png"},
        {"inner": "a2.png", "outer": "b2.png"},
    ]
    assert [name for name, _ in found] == ["showing 1", "showing 2"]


def test_pictures_named_alike_pair_by_name_and_one_that_is_missing_is_said():
    found = showings_of({
        "inner": poses("in/p1.png", "in/p2.png", "in/p3.png"),
        "outer": poses("out/p1.tif", "out/p3.tif"),
    })
    assert names_of(found) == [
        {"inner": "in/p1.png", "outer": "out/p1.tif"},
        {"inner": "in/p2.png"},
        {"inner": "in/p3.png", "outer": "out/p3.tif"},
    ]
    assert missing_in(found, ["inner", "outer"]) == {"p2 outer": "no picture of outer"}


def test_pictures_that_neither_names_nor_numbers_pair_are_refused():
    with pytest.raises(InputUnusable, match="there are of inner 2, outer 1; give one of each"):
        showings_of({"inner": poses("a1.png", "a2.png"), "outer": poses("b1.png")})


@pytest.mark.parametrize("pause_s", [0.5, 20.0])
def test_recorded_pictures_pair_by_time_however_quick_the_hand(pause_s):
    starts = [place * pause_s for place in range(3)]
    found = showings_of({
        "inner": poses("1", "2", "3", times_s=starts),
        "outer": poses("1", "2", "3", times_s=[start + 0.2 for start in starts]),
    })
    assert names_of(found) == [{"inner": n, "outer": n} for n in ("1", "2", "3")]


def test_a_picture_that_never_came_leaves_the_others_where_they_belong():
    found = showings_of({
        "inner": poses("1", "3", times_s=[0.0, 20.0]),
        "outer": poses("1", "2", "3", times_s=[0.2, 10.2, 20.2]),
    })
    assert names_of(found) == [
        {"inner": "1", "outer": "1"},
        {"outer": "2"},
        {"inner": "3", "outer": "3"},
    ]


def test_folders_are_of_the_sensors_in_order(tmp_path):
    folders = [tmp_path / name for name in ("some", "other")]
    for folder in folders:
        folder.mkdir()
        (folder / "1.png").touch()
    assert sources_by_sensor(folders, ["inner", "outer"]) == {
        "inner": folders[0],
        "outer": folders[1],
    }
    with pytest.raises(InputUnusable, match="no SOURCE of sensor outer; give one of each"):
        sources_by_sensor(folders[:1], ["inner", "outer"])
    with pytest.raises(InputUnusable, match="other: one source too many"):
        sources_by_sensor(folders, ["inner"])
    with pytest.raises(InputUnusable, match="no SOURCE given"):
        sources_by_sensor([], ["inner"])


def test_a_missing_source_may_be_none(tmp_path):
    (tmp_path / "1.png").touch()
    found = sources_by_sensor([tmp_path], ["inner", "outer"], all_wanted=False)
    assert found == {"inner": Path(tmp_path)}
