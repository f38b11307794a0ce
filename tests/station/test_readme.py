"""What the README shows is what there is: its settings load, its commands and options exist."""

import re
import shlex
from pathlib import Path

import pytest

from station.cli.main import COMMANDS, GROUPS, build_app, run
from station.settings import load_settings

README = (Path(__file__).resolve().parents[2] / "README.md").read_text(encoding="utf-8")
SHOWN = [
    shlex.split(line.partition(" #")[0])[1:]
    for block in re.findall(r"```sh[^\n]*\n(.*?)```", README, re.DOTALL)
    for line in block.replace("\\\n", "").splitlines()
    if line.startswith("station ")
]


TABLE = re.search(r"```toml\n(.*?)```", README, re.DOTALL)[1]


def test_settings_shown_load(tmp_path):
    (tmp_path / "station.toml").write_text(TABLE)
    settings = load_settings(tmp_path / "station.toml")
    assert settings.sensor("left").mounting is not None


@pytest.mark.parametrize("words", SHOWN, ids=" ".join)
def test_command_shown_exists_with_its_options(capsys, words):
    name = words[0]
    assert name in {*COMMANDS, *GROUPS}
    path = words[:2] if name in GROUPS else words[:1]
    assert run(build_app(name), [*path, "--help"]) == 0
    described = capsys.readouterr().out
    assert all(word in described for word in words if word.startswith("--"))
