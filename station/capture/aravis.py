"""Aravis in the version this driver is written for."""

import warnings
from typing import Any

import gi

gi.require_version("Aravis", "0.8")  # before the import below, or gi warns and takes any
with warnings.catch_warnings():
    # Debian 12's PyGObject has an importer of the kind that Python 3.11 warns of.
    warnings.simplefilter("ignore", ImportWarning)
    from gi.repository import Aravis as _Aravis
    from gi.repository import GLib as _GLib

Aravis: Any = _Aravis
GLib: Any = _GLib

__all__ = ["Aravis", "GLib"]
