"""Other people's software that is measured in the same run: the `bench` extra, never required."""

import importlib
from types import ModuleType

NOT_INSTALLED = "not installed: pip install treadline[bench]"


def peer(module: str) -> ModuleType | None:
    """Import a peer's module, or return None where it is not installed."""
    try:
        return importlib.import_module(module)
    except ImportError:
        return None
