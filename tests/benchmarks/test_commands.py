"""The list of commands in docs/results/benchmarks.md, and all other places that name a benchmark: they are true."""

import contextlib
import io
import json
import re
import subprocess
import sys

import pytest

from tests import ROOT, forked
from tests.benchmarks.command import run_module

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]

COMMAND = re.compile(r"python -m (benchmarks(?:\.\w+)+)([^`\n#\")]*)")


def modules() -> set[str]:
    """The modules that are commands."""
    paths = (ROOT / "benchmarks").rglob("*.py")
    return {
        ".".join(path.relative_to(ROOT).with_suffix("").parts)
        for path in paths
        if 'if __name__ == "__main__":' in path.read_text(encoding="utf-8")
    }


def named() -> list[tuple[str, str, str]]:
    """Page, module and options of every command that a page names."""
    return [
        (str(page.relative_to(ROOT)), module, options)
        for page in PAGES
        for module, options in COMMAND.findall(page.read_text(encoding="utf-8"))
    ]


def test_every_command_is_listed() -> None:
    listed = {module for page, module, _ in named() if page == "docs/results/benchmarks.md"}
    assert listed == modules()


def test_pages_name_commands_and_options_that_exist() -> None:
    pytest.importorskip("torch", reason="the extra `agents` is not installed: scripts/setup")
    done: subprocess.CompletedProcess[str] = forked.run(*sorted(modules()), command=_help)
    assert done.returncode == 0, done.stderr[-4000:]
    helps: dict[str, str] = json.loads(done.stdout)
    for page, module, options in named():
        assert module in helps, f"{page} names {module}"
        for option in re.findall(r"--[a-z-]+", options):
            assert re.search(rf"{option}\b", helps[module]), f"{page}: {module} has no {option}"


def _help(names: list[str]) -> int:
    """Print the help of commands as JSON: all in one process, as each would import the same packages again."""
    texts = {}
    for name in names:
        for loaded in [each for each in sys.modules if each in names]:
            del sys.modules[loaded]  # It is executed as a command, anew.
        said = io.StringIO()
        with contextlib.redirect_stdout(said), contextlib.suppress(SystemExit):
            run_module(name, ["--help"])
        texts[name] = said.getvalue()
    sys.stdout.write(json.dumps(texts))
    return 0 if all(text.startswith("usage: ") for text in texts.values()) else 1
