"""The commands and files of a tutorial, run as a reader would: in order, in one folder, in a shell."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from tests import ROOT
from tests.ports import free_port

TUTORIALS = ROOT / "docs" / "tutorials"

BLOCK = re.compile(r'^```(sh|python)(?: title="([^"]+)")?\n(.*?)^```$', re.MULTILINE | re.DOTALL)

CLONE = ("agents", "benchmarks", "clients", "examples", "proto", "server", "src")
"""Folders of the repository that commands of tutorials name; results go into the reader's own."""

PORTS = re.compile(r"(?<=127\.0\.0\.1:)\d+|(?<=--port )\d+")

READY = "listening on "
"""Printed by what goes on in a terminal of its own, once it can be used."""


@dataclass(frozen=True)
class Step:
    """A block of a tutorial.

    Attributes:
        kind: "run" in the reader's shell, "serve" in another terminal, "write" a file.
        text: commands or content.
        name: the file's name.
    """

    kind: str
    text: str
    name: str = ""


def steps(page: Path) -> Iterator[Step]:
    """Yield the steps of a page; its blocks of output, in the language `text`, are none."""
    for language, title, text in BLOCK.findall(page.read_text(encoding="utf-8")):
        if language == "python":
            assert title.endswith(".py"), f"{page.name}: a block of Python has no file name"
            yield Step("write", text, title)
        else:
            yield Step("serve" if title.startswith("Terminal") else "run", text)


def follow(page: Path, folder: Path) -> str:
    """Do what a tutorial says in a folder, and return what its commands printed."""
    for name in CLONE:
        (folder / name).symlink_to(ROOT / name)
    (folder / ".venv").symlink_to(sys.prefix)
    ports: dict[str, str] = {}
    log = folder / "printed"
    servers: list[subprocess.Popen[bytes]] = []
    try:
        for step in steps(page):
            text = PORTS.sub(lambda found: ports.setdefault(found[0], str(free_port())), step.text)
            if step.kind == "write":
                (folder / step.name).write_text(text, encoding="utf-8")
            elif step.kind == "serve":
                servers.append(_serve(text, folder))
            else:
                _run(text, folder, log)
    finally:
        for server in servers:
            os.killpg(server.pid, signal.SIGTERM)
            server.wait(60)
    return log.read_text(encoding="utf-8")


def _run(text: str, folder: Path, log: Path) -> None:
    with log.open("ab") as printed:
        done = subprocess.run(
            ["bash", "-euo", "pipefail", "-c", _on_path(text)], cwd=folder, stdout=printed, stderr=printed, check=False
        )
    assert done.returncode == 0, f"{text}\n{log.read_text(encoding='utf-8')[-3000:]}"


def _serve(text: str, folder: Path) -> "subprocess.Popen[bytes]":
    said = folder / "served"
    with said.open("wb") as output:
        server = subprocess.Popen(
            ["bash", "-euo", "pipefail", "-c", _on_path(text)],
            cwd=folder, stdout=output, stderr=output, start_new_session=True,
        )  # fmt: skip
    while READY not in said.read_text(encoding="utf-8"):
        assert server.poll() is None, said.read_text(encoding="utf-8")
        time.sleep(0.05)
    return server


def _on_path(text: str) -> str:
    """Return commands in a shell in which the first line of the tutorial has been run: each block has a new one."""
    return f". .venv/bin/activate\n{text}"


@contextmanager
def reader(folder: Path) -> Iterator[Path]:
    """A reader's folder, which is removed, as data and weights are large."""
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
