"""What the README and the handbook tell people to type works, in the order they stand in.

A simulated camera, a real station, a session, a calibration, a pass, replays, a backup. It does not
show that the advice is good.
"""

import csv
import json
import os
import tempfile
from pathlib import Path

import pytest
from handbook_blocks import PAGES, README, Block, ReadersShell, blocks_of, handbook_blocks

IN_HANDBOOK = [block for block in handbook_blocks() if block.runs]
IN_README = [block for block in blocks_of(README) if block.runs]


@pytest.fixture(scope="module")
def shells():
    """Run both at a time, each before its own camera; what they record is too large to be kept."""
    begun = {}
    with tempfile.TemporaryDirectory(prefix="treadline-reader-") as root:
        try:
            begun["handbook"] = ReadersShell(Path(root) / "handbook", handbook_blocks())
            begun["README"] = ReadersShell(Path(root) / "readme", blocks_of(README))
            for shell in begun.values():
                shell.wait()
            yield begun
        finally:
            for shell in begun.values():
                shell.end()


@pytest.mark.parametrize("block", IN_HANDBOOK, ids=lambda block: block.name)
def test_commands_of_the_handbook_do_what_they_say(shells, block):
    shell = shells["handbook"]
    assert shell.ended(block), shell.said(block)


@pytest.mark.parametrize("block", IN_README, ids=lambda block: block.name)
def test_commands_of_the_readme_do_what_they_say(shells, block):
    shell = shells["README"]
    assert shell.ended(block), shell.said(block)


def test_a_command_that_fails_ends_the_reading_and_what_was_begun(tmp_path):
    texts = ("sleep 600 &\necho $! > begun", "false", "touch after")
    blocks = [Block("page", line, "sh", {}, f"{text}\n") for line, text in enumerate(texts)]
    shell = ReadersShell(tmp_path / "reader", blocks)
    shell.wait()
    assert [shell.ended(block) for block in blocks] == [True, False, False]
    assert not (shell.folder / "after").exists()
    begun = int((shell.folder / "begun").read_text())
    with pytest.raises(ProcessLookupError):
        os.kill(begun, 0)


def test_every_page_has_commands_that_are_run():
    assert {block.page for block in IN_HANDBOOK} == set(PAGES)


def test_a_reader_has_a_calibration_that_passed_its_gates(shells):
    quality = json.loads((shells["handbook"].folder / "calibration.json").read_text())["quality"]
    assert quality
    assert all(gate["passed"] for gate in quality.values())


def test_a_reader_has_wheels_that_were_measured(shells):
    with (shells["handbook"].folder / "wheels.csv").open(newline="") as table:
        wheels = list(csv.DictReader(table))
    assert wheels
    assert not any(wheel["reason"] for wheel in wheels)
