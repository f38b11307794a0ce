"""What the kernel says of this host in its small files."""

import os
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Host:
    """A host, by the root of its file tree: ``/``, or a made-up one."""

    root: Path = Path("/")

    def text(self, path: str) -> str | None:
        """Return what stands in a file, None where there is none or it says nothing."""
        try:
            return (self.root / path).read_text(encoding="utf-8", errors="replace").strip() or None
        except OSError:
            return None

    def number(self, path: str) -> int | None:
        """Return the first number of a file, None where there is none."""
        words = (self.text(path) or "").split()
        try:
            return int(words[0])
        except (IndexError, ValueError):
            return None

    def sysctl(self, name: str) -> int | None:
        """Return a kernel setting such as ``net.core.rmem_max``."""
        return self.number(f"proc/sys/{name.replace('.', '/')}")

    def field(self, path: str, name: str) -> str | None:
        """Return the value behind ``name:`` in a file of such lines."""
        for line in (self.text(path) or "").splitlines():
            key, colon, value = line.partition(":")
            if colon and key.strip() == name:
                return value.strip()
        return None


def as_root(command: str) -> str:
    """Return a command as this user must type it where only root may do it."""
    return command if os.geteuid() == 0 else f"sudo {command}"


def to_keep(name: str, value: int) -> str:
    """Return the command that sets a kernel setting now and after the next start."""
    file = "/etc/sysctl.d/60-treadline.conf"
    write, load = as_root(f"tee -a {file}"), as_root(f"sysctl -p {file}")
    return f"echo '{name} = {value}' | {write} && {load}"
