"""Aravis in the version this driver is written for."""

from typing import Any

import gi

gi.require_version("Aravis", "0.8")  # before the import below, or gi warns and takes any
from gi.repository import Aravis as _Aravis  # noqa: E402
from gi.repository import GLib as _GLib  # noqa: E402

Aravis: Any = _Aravis
GLib: Any = _GLib

__all__ = ["Aravis", "GLib"]
