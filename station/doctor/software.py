"""The programs this one stands on: there, and of a version it was made for."""

import re
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, requires, version

from station.doctor.finding import Finding
from station.doctor.host import as_root

_DISTRIBUTION = "treadline"
_ARAVIS_PACKAGES = "python3-gi gir1.2-aravis-0.8"
_ARAVIS_TIMEOUT_S = 10.0
_ASK_ARAVIS = """
from station.capture.aravis import Aravis
import gi, re
Aravis.GvStreamOption.PACKET_SOCKET_DISABLED
loaded = re.findall(r"libaravis[^ ]*?\\.so\\.([0-9.]+)", open("/proc/self/maps").read())
print(gi.__version__, loaded[0] if loaded else "of unknown number")
"""
"""Run in a process of its own: the library starts threads, and a broken one may not return."""


def probe_aravis(script: str = _ASK_ARAVIS) -> str | None:
    """Return the versions of PyGObject and Aravis, None where they do not load."""
    command = [sys.executable, "-c", script]
    try:
        asked = subprocess.run(  # noqa: S603  our own code
            command, capture_output=True, text=True, timeout=_ARAVIS_TIMEOUT_S, check=True
        )
    except (subprocess.CalledProcessError, subprocess.TimeoutExpired):
        return None
    return asked.stdout.strip()


def judge_aravis(versions: str | None) -> Finding:
    """Judge the driver: Aravis 0.8, from the system's packages."""
    if versions is None:
        cure = as_root(f"apt-get install --no-install-recommends {_ARAVIS_PACKAGES}")
        return Finding("Aravis", f"{sys.executable} cannot load it", cure)
    gobject, aravis = versions.split(" ", 1)
    return Finding("Aravis", f"Aravis {aravis}, PyGObject {gobject}")


def judge_packages(requirements: list[str] | None = None) -> Finding:
    """Every package this one requires is there, in an allowed version."""
    needed = (requires(_DISTRIBUTION) or []) if requirements is None else requirements
    wanted = [text for text in needed if "extra ==" not in text]
    wrong = [fault for text in wanted if (fault := _fault(text)) is not None]
    if not wrong:
        main = ", ".join(f"{name} {version(name)}" for name in ("numpy", "mcap", "protobuf"))
        return Finding("packages", f"{len(wanted)} as required ({main}, …)")
    cure = f"{sys.executable} -m pip install --require-hashes -r requirements.lock"
    return Finding("packages", "; ".join(wrong), cure)


def _fault(requirement: str) -> str | None:
    """Return what is wrong with a package, None where nothing is."""
    name = re.split(r"[^A-Za-z0-9._-]", requirement, maxsplit=1)[0]
    try:
        found = version(name)
    except PackageNotFoundError:
        return f"{name} is not installed"
    least = re.search(r">=([\d.]+)", requirement)
    below = re.search(r"<([\d.]+)", requirement)
    too_old = least is not None and _release(found) < _release(least[1])
    too_new = below is not None and _release(found) >= _release(below[1])
    return f"{name} {found}, allowed: {requirement}" if too_old or too_new else None


def _release(text: str) -> tuple[int, ...]:
    """Return a version's numbers, zeros at their end left out, so that 3 and 3.0 are equal."""
    numbers = [int(part) for part in re.findall(r"\d+", text.split("+")[0])[:4]]
    while numbers and numbers[-1] == 0:
        numbers.pop()
    return tuple(numbers)
