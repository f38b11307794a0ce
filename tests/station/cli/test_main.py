"""How errors become exit codes and one line; what single commands do stands with them."""

import pytest
import typer

from calib import TargetNotFound
from station.cli.main import COMMANDS, GROUPS, build_app, run
from station.errors import InputUnusable, NothingMeasurable


def app_that(does):
    app = typer.Typer(rich_markup_mode=None)
    app.command()(does)
    return app


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (InputUnusable("seen\nallowed"), 2),
        (TargetNotFound("seen\nallowed"), 2),
        (NothingMeasurable("seen\nallowed"), 1),
    ],
)
def test_refusal_is_one_line_on_stderr_and_its_exit_code(capsys, error, code):
    def refuse() -> None:
        raise error

    assert run(app_that(refuse), []) == code
    out, err = capsys.readouterr()
    assert (out, err) == ("", "station: seen allowed\n")


def test_error_that_is_nobodys_mistake_is_not_hidden():
    def break_down() -> None:
        raise RuntimeError

    with pytest.raises(RuntimeError):
        run(app_that(break_down), [])


@pytest.mark.parametrize(
    "arguments", [["nonsense"], ["calibrate", "x.png"], ["calibrate", "--bad"]]
)
def test_wrong_usage_is_one_line_and_exit_2(capsys, arguments):
    assert run(build_app(), arguments) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert "--help" in err


def test_help_offered_for_a_misspelt_command_is_one_that_exists(capsys):
    assert run(build_app(), ["calibrat"]) == 2
    assert "(`station --help` tells" in capsys.readouterr().err


@pytest.mark.parametrize("name", [*COMMANDS, *GROUPS])
def test_every_command_has_help(capsys, name):
    assert run(build_app(name), [name, "--help"]) == 0
    assert name in capsys.readouterr().out
