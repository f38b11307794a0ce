"""The name and version this software signs its results with."""

from importlib.metadata import version

SOFTWARE = f"treadline {version('treadline')}"
