"""Serves the demo station until Ctrl-C: `demo_station_serve.py [--port N] [--data DIR]`."""

import argparse
import contextlib
import logging
import signal
import tempfile
from pathlib import Path

import structlog
from demo_station_data import DemoData
from demo_station_serving import Demo, served, served_quietly

from station.processes.stop_signal import StopSignal


def main() -> None:
    """Make the data where they are not there, serve a copy of them, say where."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("--port", type=int, default=0, help="port of the page; free by default")
    asked.add_argument("--data", type=Path, help="folder that keeps the data; used where it is")
    asked.add_argument("--quiet", action="store_true", help="the API alone, without cameras")
    given = asked.parse_args()
    structlog.configure(wrapper_class=structlog.make_filtering_bound_logger(logging.ERROR))
    # As Ctrl-C, so that what was begun is undone; once it serves, both only end the waiting.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    with (
        contextlib.suppress(KeyboardInterrupt),
        tempfile.TemporaryDirectory(prefix="treadline-demo-") as temporary,
    ):
        folder = Path(temporary)
        data = DemoData.kept(given.data or folder / "built")
        (folder / "served").mkdir()
        serving = (
            served_quietly(data, folder / "served", port=given.port)
            if given.quiet
            else served(data, folder / "served", port=given.port)
        )
        with serving as demo, StopSignal() as stop:
            _say(demo)
            stop.wait()


def _say(demo: Demo) -> None:
    print(demo.url, flush=True)
    for scope, key in demo.keys.items():
        print(f"{scope:10} {key}", flush=True)
    print(f"data in {demo.folder}; Ctrl-C ends it", flush=True)


if __name__ == "__main__":
    main()
