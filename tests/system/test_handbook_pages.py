"""What the handbook says is what there is, and all of it: links, marks, alarms, settings."""

import re
import tomllib
from collections import Counter

import pytest
from handbook_blocks import HANDBOOK, PAGES, README, blocks_of, handbook_blocks
from setuptools import find_namespace_packages

from station.settings import load_settings
from station.watching import Severity, Trouble, TroubleKind

ALL = [README, *(HANDBOOK / f"{page}.md" for page in PAGES)]
NEEDS = {
    "root": "apt and systemd change the machine; the package's own tests install it",
    "checkout": "they make the environment that these tests run in, and run them",
    "demo": "a minute; test_demo.py runs it",
    "train": "test_readme_controller.py runs it, the worker ending the job while it is followed",
    "bucket": "an archive on an S3 server; tests/station/replay/test_s3.py starts one",
    "yours": "recordings, rigs and profiles of one's own; test_readme.py knows each option",
}
"""What a block may need that is not here, and why; where it is run instead."""
MOST_NOT_RUN = 10


def test_there_is_no_page_beside_those_in_order():
    assert {path.stem for path in HANDBOOK.glob("*.md")} == set(PAGES)


def test_pages_come_with_the_package():
    assert "station.handbook" in find_namespace_packages(where=HANDBOOK.parents[1])


@pytest.mark.parametrize("page", PAGES)
def test_a_page_begins_with_what_it_is_for_and_ends_with_what_to_do(page):
    text = (HANDBOOK / f"{page}.md").read_text(encoding="utf-8")
    title, _, after = text.partition("\n\n")
    assert re.fullmatch(r"# .+", title)
    assert after.startswith("For ")
    assert re.findall(r"^## (.+)$", text, re.MULTILINE)[-1] == "When it does not work"


def test_a_block_that_is_not_run_says_what_it_needs():
    blocks = [*blocks_of(README), *handbook_blocks()]
    needed = Counter(block.marks["needs"] for block in blocks if "needs" in block.marks)
    assert needed.keys() == NEEDS.keys()
    assert needed.total() <= MOST_NOT_RUN
    assert {block.language for block in blocks} == {"sh", "toml", "python"}


@pytest.mark.parametrize("path", ALL, ids=lambda path: path.stem)
def test_links_lead_somewhere(path):
    for target, _, place in re.findall(
        r"\]\((?!https?:)([^)#]*)(#([^)]*))?\)", path.read_text("utf-8")
    ):
        found = path if not target else path.parent / target
        assert found.exists(), target
        if place:
            heads = re.findall(r"^#+ (.+)$", found.read_text("utf-8"), re.MULTILINE)
            assert place in {_anchor(head) for head in heads}, place


def _anchor(head):
    return re.sub(r"[^\w -]", "", head.lower()).replace(" ", "-")


def test_the_readme_leads_to_every_page():
    text = README.read_text(encoding="utf-8")
    assert [page for page in PAGES if f"(station/handbook/{page}.md)" not in text] == []


def test_every_alarm_is_described_and_no_other():
    rows = re.findall(
        r"^\| `(\w+)` \| [\w, ]+ \| (\w+) \| ",
        (HANDBOOK / "alarms.md").read_text(encoding="utf-8"),
        re.MULTILINE,
    )
    assert len(rows) == len(TroubleKind)
    assert dict(rows) == {
        kind.value: Trouble(kind, "a part", "what", None).severity.value for kind in TroubleKind
    }
    assert {grave for _, grave in rows} == {each.value for each in Severity}


def test_metrics_that_alerts_rest_on_are_in_the_table_of_metrics():
    text = (HANDBOOK / "alarms.md").read_text(encoding="utf-8")
    named = set(re.findall(r"\bstation_[a-z_]+\b", text))
    listed = set(re.findall(r"^\| `(station_\w+)` \|", text, re.MULTILINE))
    assert named == listed


TABLES = [block for block in [*blocks_of(README), *handbook_blocks()] if block.language == "toml"]


@pytest.mark.parametrize("block", TABLES, ids=lambda block: block.name)
def test_settings_shown_load_in_a_station_that_has_their_sensors(tmp_path, block):
    told = tomllib.loads(block.text)
    names = [name for rig in told.get("rigs", ()) for name in rig["sensors"]] or ["left"]
    sensors = [
        f'[[sensors]]\nid = "{name}"\naddress = "192.168.10.{place}"\n'
        for place, name in enumerate(names, start=2)
    ]
    others = [] if "sensors" in told else ['data_dir = "data"', *sensors]
    (tmp_path / "station.toml").write_text("\n".join([*others, block.text]))
    settings = load_settings(tmp_path / "station.toml")
    assert all(getattr(settings, name) for name in told)
