"""The tree of commands, and how an error becomes a line and an exit code."""

import importlib
import sys
from collections.abc import Callable
from typing import Any

import typer

from station.errors import NothingMeasurable, StationError

EXIT_NO = 1
EXIT_UNUSABLE = 2
EXIT_INTERRUPTED = 130

COMMANDS: dict[str, tuple[str, str]] = {
    "demo": ("station.cli.demo", "demo"),
    "serve": ("station.cli.serve", "serve"),
    "record": ("station.cli.record", "record"),
    "import": ("station.cli.importing", "import_sources"),
    "intrinsics": ("station.cli.intrinsics", "intrinsics"),
    "calibrate": ("station.cli.calibrate", "calibrate"),
    "measure": ("station.cli.measure", "measure"),
    "replay": ("station.cli.replay", "replay"),
    "recalibrate": ("station.cli.recalibrate", "recalibrate"),
    "compare": ("station.cli.compare", "compare"),
    "table": ("station.cli.table", "table"),
    "gauge": ("station.cli.gauge", "gauge"),
    "results": ("station.cli.results", "results"),
    "audit": ("station.cli.audit", "audit"),
    "backup": ("station.cli.backup", "backup"),
    "restore": ("station.cli.restore", "restore"),
    "doctor": ("station.cli.doctor", "doctor"),
    "bench": ("station.cli.bench", "bench"),
}
GROUPS: dict[str, str] = {
    "camera": "station.cli.camera",
    "config": "station.cli.config",
    "recording": "station.cli.recording",
    "rig": "station.cli.rig",
    "evaluate": "station.cli.evaluate",
    "reference": "station.cli.reference",
    "keys": "station.cli.keys",
    "api": "station.cli.api",
    "fleet": "station.cli.fleet",
}


def build_app(wanted: str | None = None) -> typer.Typer:
    """Assemble the commands; with a name of one `wanted`, that one alone is imported.

    Importing every command costs over a second, running one a tenth of it.
    """
    app = typer.Typer(
        help="A trackside station that measures railway wheels with laser light.",
        no_args_is_help=True,
        rich_markup_mode=None,
        pretty_exceptions_enable=False,
        add_completion=False,
    )
    app.callback()(_root)
    for name, (module, function) in COMMANDS.items():
        if wanted in {None, name}:
            app.command(name)(_load(module, function))
    for name, module in GROUPS.items():
        if wanted in {None, name}:
            app.add_typer(_load(module, "app"), name=name)
    return app


def _root() -> None:
    """A trackside station that measures railway wheels with laser light."""  # noqa: D401  help text


def _load(module: str, name: str) -> Any:
    return getattr(importlib.import_module(module), name)


def main() -> None:
    """Run the command line and leave with its exit code."""
    known = {*COMMANDS, *GROUPS}
    wanted = sys.argv[1] if len(sys.argv) > 1 and sys.argv[1] in known else None
    sys.exit(run(build_app(wanted), sys.argv[1:]))


def run(app: Callable[..., Any], arguments: list[str]) -> int:
    """Run `app` and return the exit code; every refusal is one line on stderr."""
    try:
        code = app(args=arguments, prog_name="station", standalone_mode=False)
    except NothingMeasurable as error:
        return _say(str(error), EXIT_NO)
    except StationError as error:
        return _say(str(error), EXIT_UNUSABLE)
    except typer.TyperException as error:
        named = [word for word in arguments[:1] if word in {*COMMANDS, *GROUPS}]
        command = " ".join(["station", *named])
        return _say(f"{_message(error)} (`{command} --help` tells what is allowed)", EXIT_UNUSABLE)
    except (KeyboardInterrupt, typer.Abort):
        return _say("interrupted", EXIT_INTERRUPTED)
    except BrokenPipeError:
        return 0
    except Exception as error:
        if not _is_refusal_of_the_mathematics(error):
            raise
        return _say(str(error), EXIT_UNUSABLE)
    return code if isinstance(code, int) else 0


def _is_refusal_of_the_mathematics(error: Exception) -> bool:
    # Imported here: every process of the station passes through this module, few calculate.
    from calib import CalibError  # noqa: PLC0415
    from measure import MeasureError  # noqa: PLC0415

    return isinstance(error, CalibError | MeasureError)


def _message(error: typer.TyperException) -> str:
    formatted = getattr(error, "format_message", None)
    return str(formatted() if formatted else error).rstrip(".")


def _say(message: str, code: int) -> int:
    line = " ".join(message.split())
    print(f"station: {line}", file=sys.stderr)  # noqa: T201  this is the one line
    return code
