"""Pages of the command lines, from their parsers."""

import argparse
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

import arramon_agents.train
import arramon_client.arguments
import arramon_client.cli
import arramon_server.cli
from website.page import Page

SECTION = "Commands"


class _Parsed(BaseException):
    """Carries the parser of a command out of it, before it parses anything."""

    def __init__(self, parser: argparse.ArgumentParser) -> None:
        self.parser = parser


def pages() -> Sequence[Page]:
    """Return a page for each of the three programs."""
    return (
        _page("client", "arramon-client", client()),
        _page("server", "arramon-server", server()),
        _page("train", "arramon-train", [parser_of(lambda: arramon_agents.train.main([]))]),
    )


def client() -> list[argparse.ArgumentParser]:
    """Return the parsers of `arramon-client`: its own, and those of its commands."""
    commands = [lambda main=main: main([]) for _, main in sorted(arramon_client.cli.COMMANDS.items())]
    return [arramon_client.arguments.parser(), *map(parser_of, commands)]


def server() -> list[argparse.ArgumentParser]:
    """Return the parsers of `arramon-server`: its own, and those of its commands and their actions."""
    return list(_with_commands(arramon_server.cli.parser()))


def parser_of(command: Callable[[], int]) -> argparse.ArgumentParser:
    """Return the parser that a command parses its arguments with.

    Raises:
        ValueError: if the command parses none.
    """
    with _parsing_raises():
        try:
            command()
        except _Parsed as found:
            return found.parser
    raise ValueError(f"{command} parses no arguments")


@contextmanager
def _parsing_raises() -> Iterator[None]:
    def parse(parser: argparse.ArgumentParser, *_: object) -> None:
        raise _Parsed(parser)

    kept = argparse.ArgumentParser.parse_known_args
    argparse.ArgumentParser.parse_known_args = parse  # type: ignore[assignment,method-assign]
    try:
        yield
    finally:
        argparse.ArgumentParser.parse_known_args = kept  # type: ignore[method-assign]


def _with_commands(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for its in dict.fromkeys(action.choices.values()):
                yield from _with_commands(its)


def _page(name: str, title: str, parsers: Sequence[argparse.ArgumentParser]) -> Page:
    text = f"# {title}\n\n" + "\n".join(map(_section, parsers))
    return Page(f"reference/commands/{name}.md", SECTION, title, text)


def _section(parser: argparse.ArgumentParser) -> str:
    """Return the section of one command: what it does, its usage, its arguments."""
    usage = parser.format_usage().removeprefix("usage: ").rstrip()
    parts = [f"## {parser.prog}\n"]
    if parser.description:
        parts.append(f"{_escaped(_filled(parser, parser.description))}\n")
    parts.append(f"```text\n{usage}\n```\n")
    if rows := list(_rows(parser)):
        parts.append("\n".join(("| argument | meaning |", "| --- | --- |", *rows)) + "\n")
    if parser.epilog:
        parts.append(f"```text\n{_filled(parser, parser.epilog)}\n```\n")
    return "\n".join(parts)


def _rows(parser: argparse.ArgumentParser) -> Iterator[str]:
    formatter = parser._get_formatter()
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for choice in action._choices_actions:
                yield f"| `{choice.dest}` | {_cell(choice.help or '')} |"
        elif not isinstance(action, argparse._HelpAction) and action.help != argparse.SUPPRESS:
            help_text = formatter._expand_help(action) if action.help else ""
            yield f"| `{formatter._format_action_invocation(action)}` | {_cell(help_text)} |"


def _filled(parser: argparse.ArgumentParser, text: str) -> str:
    return text % {"prog": parser.prog} if "%(prog)" in text else text


def _cell(text: str) -> str:
    return _escaped(" ".join(text.split())).replace("|", "\\|")


def _escaped(text: str) -> str:
    """Return a text in which nothing is taken for Markdown or HTML but code in backticks."""
    parts = text.split("`")
    for index in range(0, len(parts), 2):
        for sign in ("\\", "<", "*", "_", "["):
            parts[index] = parts[index].replace(sign, {"<": "&lt;"}.get(sign, "\\" + sign))
    return "`".join(parts)
