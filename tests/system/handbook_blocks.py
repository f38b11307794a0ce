"""The blocks of code in README and handbook, and a shell that runs them as a reader would."""

import contextlib
import os
import re
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from station.processes.port import port_for_later

ROOT = Path(__file__).resolve().parents[2]
README = ROOT / "README.md"
HANDBOOK = ROOT / "station" / "handbook"
PAGES = (
    "install",
    "aim-and-focus",
    "calibrate",
    "controller",
    "report",
    "replay",
    "fleet",
    "alarms",
    "camera-changed",
    "backup",
)
"""In the order in which their commands build on each other."""

_FENCE = re.compile(r"^```(\w+)([^\n]*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_BEGUN, _ENDED = "@@ begun", "@@ ended"
_SHOWN_PORT = "8080"
_LONGEST_S = 540.0
_ENDING_S = 60.0


@dataclass(frozen=True, slots=True)
class Block:
    """A fenced block: where it stands, its language, its marks, as ``needs=root``."""

    page: str
    line: int
    language: str
    marks: Mapping[str, str]
    text: str

    @property
    def name(self) -> str:
        """The place that a reader finds it at."""
        return f"{self.page}:{self.line}"

    @property
    def runs(self) -> bool:
        """Whether it is run here: it may need what a test machine does not have."""
        return self.language == "sh" and "needs" not in self.marks


def blocks_of(path: Path) -> list[Block]:
    """Return all fenced blocks of a page."""
    text = path.read_text(encoding="utf-8")
    return [
        Block(
            page=path.stem,
            line=text.count("\n", 0, found.start()) + 1,
            language=found[1],
            marks=dict(mark.split("=", 1) for mark in found[2].split()),
            text=found[3],
        )
        for found in _FENCE.finditer(text)
    ]


def handbook_blocks() -> list[Block]:
    """Return the blocks of all pages, in their order."""
    return [block for page in PAGES for block in blocks_of(HANDBOOK / f"{page}.md")]


class ReadersShell:
    """One bash that runs blocks one after the other; what they begin ends with it.

    It stops at the first command that fails, as a reader would.
    """

    def __init__(self, folder: Path, blocks: Sequence[Block]) -> None:
        self.folder = folder
        self._log = folder.with_suffix(".log")
        folder.mkdir()
        script = "\n".join(_lines(blocks, str(port_for_later())))
        commands = Path(sys.executable).parent
        here = {"PATH": f"{commands}:{os.environ['PATH']}", "NO_PROXY": "*", "no_proxy": "*"}
        with self._log.open("w") as log:
            # By a file: what a block begins in the background may hold pipes open.
            self._bash = subprocess.Popen(
                ["bash", "-euo", "pipefail", "-c", script],
                cwd=folder,
                env=os.environ | here,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    def wait(self) -> None:
        """Wait until all blocks are run, or one has failed; then end what is left."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self._bash.wait(_LONGEST_S)
        self.end()

    def end(self) -> None:
        """End what still runs; safe to call twice."""
        for end in (signal.SIGTERM, signal.SIGKILL):
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._bash.pid, end)
                self._wait_for_all(_ENDING_S)
        self._bash.wait(_ENDING_S)

    def _wait_for_all(self, seconds: float) -> None:
        """Wait for bash and all it began; ProcessLookupError tells that none is left."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            self._bash.poll()
            os.killpg(self._bash.pid, 0)
            time.sleep(0.05)

    def ended(self, block: Block) -> bool:
        """Tell whether a block was run to its end."""
        return f"{_ENDED} {block.name}\n" in self._log.read_text(errors="replace")

    def said(self, block: Block) -> str:
        """Return what a block printed, up to the next."""
        _, _, since = self._log.read_text(errors="replace").partition(f"{_BEGUN} {block.name}\n")
        return since.partition(_BEGUN)[0]


def _lines(blocks: Sequence[Block], port: str) -> Iterator[str]:
    for block in blocks:
        text = block.text.replace(_SHOWN_PORT, port)
        if "file" in block.marks:
            yield f"printf %s {shlex.quote(text)} > {shlex.quote(block.marks['file'])}"
        elif block.runs:
            yield f"echo; echo '{_BEGUN} {block.name}'"
            yield _may_say_no(text) if block.marks.get("exit") == "0,1" else text
            yield f"echo; echo '{_ENDED} {block.name}'"


def _may_say_no(text: str) -> str:
    """Let the last command exit with 1: what looks for something wrong may find it."""
    before, _, last = text.rstrip("\n").rpartition("\n")
    return f"{before}\n{{ {last}\n}} || [ $? = 1 ]"
