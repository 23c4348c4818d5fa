"""The commands that pages print: there are such commands, and they take these options."""

import contextlib
import io
import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest

from arramon_client import arguments
from arramon_client.cli import COMMANDS
from arramon_server import cli
from tests import ROOT

DOCS = ROOT / "docs"

BLOCK = re.compile(r"^( *)```(?:sh|text)[^\n]*\n(.*?)^\1```$", re.MULTILINE | re.DOTALL)

COMMAND = re.compile(r"(?:^|[;(] *)arramon-(server|client) (.*)$")

ENDS = {"|", ">", "&", "&&", ";"}
"""Words of the shell at which a command's own words end."""

RUN = "0" * 32
"""What a reader writes for RUN."""

PAGES = sorted(page for page in DOCS.rglob("*.md"))


def commands(text: str) -> Iterator[tuple[str, list[str]]]:
    """Yield the commands in a page's blocks, each as "server" or "client" and its words."""
    for _, block in BLOCK.findall(text):
        for line in block.replace("\\\n", " ").splitlines():
            found = COMMAND.search(line.strip())
            if found and not found[2].startswith("$"):  # A variable may hold several words.
                words = shlex.split(found[2], comments=True)
                end = next((at for at, word in enumerate(words) if word in ENDS or word.endswith(")")), len(words))
                yield found[1], words[:end]


def refusal(program: str, words: list[str]) -> str:
    """Return what a program prints if it does not take these words; empty if it does."""
    words = [RUN if word == "RUN" else word for word in words]
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
        try:
            if program == "server":
                cli.parser(words[0]).parse_args(words)
            elif words[0].startswith("-"):
                arguments.parse(words)
            elif words[0] not in COMMANDS:
                return f"arramon-client has no command {words[0]!r}"
        except SystemExit:
            return printed.getvalue() or "it exits"
    return ""


@pytest.mark.parametrize("page", PAGES, ids=[str(page.relative_to(DOCS)) for page in PAGES])
def test_programs_take_the_commands_of_a_page(page: Path) -> None:
    refused = [
        f"{' '.join(words)}: {said}"
        for program, words in commands(page.read_text(encoding="utf-8"))
        if (said := refusal(program, words))
    ]
    assert refused == []


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("arramon-server migrate", "invalid choice: 'migrate'"),
        ("arramon-server backup --nothing x", "unrecognized arguments: --nothing"),
        ("(umask 077; arramon-server token make Ann > token)", "invalid choice: 'make'"),
        ("arramon-client migrate", "has no command 'migrate'"),
        ("arramon-client --agent x --nothing", "unrecognized arguments: --nothing"),
    ],
)
def test_a_command_that_does_not_exist_is_found(line: str, said: str) -> None:
    ((program, words),) = commands(f"# Page\n\n1. A step:\n\n    ```sh\n    {line}      # a comment\n    ```\n")
    assert said in refusal(program, words)


def test_the_page_on_upgrades_has_commands() -> None:
    page = (DOCS / "how-to" / "upgrading.md").read_text(encoding="utf-8")
    used = {words[0] for program, words in commands(page) if program == "server"}
    assert used == {"backup", "config", "health", "rescore", "serve"}
