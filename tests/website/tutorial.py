"""The commands and files of a tutorial, run as a reader would: in order, in one folder, in the named terminals."""

import os
import re
import select
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from tests import ROOT
from tests.ports import free_port

TUTORIALS = ROOT / "docs" / "tutorials"

BLOCK = re.compile(r'^```(sh|python)(?: title="([^"]+)")?\n(.*?)^```$', re.MULTILINE | re.DOTALL)

TERMINAL = re.compile(r"Terminal (\d)(: leave it running)?")
"""Title of a block that is run in another terminal than the block before, or that goes on in its terminal."""

CLONE = ("agents", "benchmarks", "clients", "examples", "proto", "server", "src")
"""Folders of the repository that commands of tutorials name; results go into the reader's own."""

PORTS = re.compile(r"(?<=127\.0\.0\.1:)\d+|(?<=--port )\d+")

READY = "listening on "
"""Printed by what goes on in a terminal, once it can be used."""

OWN_COMMAND = "arramon-client"
"""A command that a new terminal does not find."""


@dataclass(frozen=True)
class Step:
    """A block of a tutorial.

    Attributes:
        kind: "run" commands to their end, "serve" in a terminal that is busy from then on, "write" a file.
        text: commands or content.
        name: the file's name.
        terminal: number of the terminal in which commands run.
    """

    kind: str
    text: str
    name: str = ""
    terminal: str = "1"


def steps(page: Path) -> Iterator[Step]:
    """Yield the steps of a page; its blocks of output, in the language `text`, are none."""
    terminal = "1"
    for language, title, text in BLOCK.findall(page.read_text(encoding="utf-8")):
        if language == "python":
            assert title.endswith(".py"), f"{page.name}: a block of Python has no file name"
            yield Step("write", text, title)
            continue
        found = TERMINAL.fullmatch(title or f"Terminal {terminal}")
        assert found, f"{page.name}: the title {title!r} names no terminal"
        terminal = found[1]
        yield Step("serve" if found[2] else "run", text, terminal=terminal)


class Terminal:
    """A shell of the reader's, which keeps its variables from one block to the next.

    Args:
        folder: the working directory.
        name: its output goes to the file `printed-NAME` in that folder.
    """

    def __init__(self, folder: Path, name: str) -> None:
        self._name, self._busy = name, False
        self._log = folder / f"printed-{name}"
        done, says = os.pipe()
        with self._log.open("wb") as printed:
            self._shell = subprocess.Popen(
                ["bash", "-euo", "pipefail"], cwd=folder, env=_environment(), stdin=subprocess.PIPE, stdout=printed,
                stderr=printed, pass_fds=(says,), start_new_session=True,
            )  # fmt: skip
        os.close(says)
        self._done, self._says = os.fdopen(done), says

    def printed(self) -> str:
        """Return what its commands have printed."""
        return self._log.read_text(encoding="utf-8")

    def run(self, text: str) -> None:
        """Run commands to their end.

        Raises:
            AssertionError: if one fails, or the terminal is busy.
        """
        self._enter(text, f"echo >&{self._says}")
        assert self._done.readline() == "\n", f"{text}\n{self.printed()[-3000:]}"

    def serve(self, text: str) -> None:
        """Run commands, the last of which goes on, until it can be used.

        Raises:
            AssertionError: if one ends, or the terminal is busy.
        """
        before = len(self.printed())
        self._enter(text, "exit")
        self._busy = True
        while READY not in self.printed()[before:]:
            assert self._shell.poll() is None, f"{text}\n{self.printed()[before:]}"
            time.sleep(0.05)

    def close(self) -> None:
        """End the shell and what goes on in it."""
        assert self._shell.stdin
        if self._shell.poll() is None:
            os.killpg(self._shell.pid, signal.SIGTERM if self._busy else signal.SIGKILL)
        self._shell.stdin.close()
        self._shell.wait(60)
        ended, _, _ = select.select([self._done], [], [], 60)  # What goes on holds the other end of the pipe, too.
        self._done.close()
        assert ended, f"terminal {self._name}: what went on in it ignores SIGTERM"

    def _enter(self, text: str, then: str) -> None:
        assert not self._busy, f"terminal {self._name} is busy, so that its reader cannot enter:\n{text}"
        assert self._shell.stdin
        # In braces the commands are the shell's own, and none of them reads what is entered next.
        self._shell.stdin.write(f"{{\n{text}}} </dev/null\n{then}\n".encode())
        self._shell.stdin.flush()


def follow(page: Path, folder: Path) -> str:
    """Do what a tutorial says in a folder, and return what its commands printed."""
    for name in CLONE:
        (folder / name).symlink_to(ROOT / name)
    (folder / ".venv").symlink_to(sys.prefix)
    ports: dict[str, str] = {}
    terminals: dict[str, Terminal] = {}
    try:
        for step in steps(page):
            text = PORTS.sub(lambda found: ports.setdefault(found[0], str(free_port())), step.text)
            if step.kind == "write":
                (folder / step.name).write_text(text, encoding="utf-8")
                continue
            if step.terminal not in terminals:
                terminals[step.terminal] = Terminal(folder, step.terminal)
            terminal = terminals[step.terminal]
            (terminal.serve if step.kind == "serve" else terminal.run)(text)
        return "".join(terminal.printed() for terminal in terminals.values())
    finally:
        for terminal in terminals.values():
            terminal.close()


def _environment() -> Mapping[str, str]:
    """Return the environment of a new terminal, in which no virtual environment is active."""
    paths = [path for path in os.environ["PATH"].split(os.pathsep) if not (Path(path) / OWN_COMMAND).exists()]
    return {**os.environ, "PATH": os.pathsep.join(paths)}


@contextmanager
def reader(folder: Path) -> Iterator[Path]:
    """A reader's folder, which is removed, as data and weights are large."""
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
