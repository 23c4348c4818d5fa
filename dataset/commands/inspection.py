"""The commands `show`, `stats` and `check-instruction`, which inspect episodes and instructions."""

import argparse
import json
import sys
from collections.abc import Iterator
from pathlib import Path

from arramon_client.world import PHASES
from arramon_dataset.instruction_check import check_texts
from arramon_lang.quality import Failure, any_blocks
from arramon_server.commands import Commands
from arramon_server.errors import BadInput


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add all three commands."""
    show = commands.add_parser(
        "show", parents=[common], help="draw an episode: a map, and the agent's views; or the map of a section"
    )
    show.add_argument("episode", nargs="?", help="id of the episode, such as 8900")
    show.add_argument("--section", metavar="ID", help="draw this section instead, with everything recovered from texts")
    show.add_argument("--split", help="split of the episode or section (default: the first split that has it)")
    show.add_argument("--output", type=Path, default=Path(), help="folder for the pictures (default: current folder)")
    show.set_defaults(command=_show)

    stats = commands.add_parser("stats", parents=[common], help="print statistics of the instructions and paths")
    stats.add_argument("--split", nargs="+", default=(), metavar="S", help="splits to compare (default: all)")
    stats.add_argument("--lang", nargs="+", default=(), metavar="L", help="languages (default: all in the splits)")
    stats.add_argument(
        "--sample",
        type=int,
        default=2000,
        metavar="N",
        help="number of instructions that the diversity is measured on (default: %(default)s)",
    )
    stats.add_argument("--output", type=Path, metavar="FOLDER", help="also draw plots into this folder")
    stats.add_argument("--json", action="store_true", help="print JSON instead of tables")
    stats.set_defaults(command=_stats)
    _add_check(commands, common)


def _add_check(commands: Commands, common: argparse.ArgumentParser) -> None:
    check = commands.add_parser(
        "check-instruction", parents=[common], help="print the quality checks that a text fails"
    )
    check.add_argument(
        "texts",
        nargs="*",
        metavar="TEXT",
        help="an instruction (default: with --episode its own instructions, otherwise each line of standard input)",
    )
    check.add_argument("--lang", default="en", help="language of the text (default: %(default)s)")
    check.add_argument("--phase", required=True, choices=PHASES, help="phase of the instruction")
    check.add_argument("--target", default="", metavar="WORDS", help="object it must name: 'dotted brown bucket'")
    check.add_argument(
        "--first-turn",
        type=float,
        default=0.0,
        metavar="DEGREES",
        help="angle by which the path turns before its first step",
    )
    check.add_argument(
        "--episode", metavar="ID", help="also check that the things a text names exist in this episode's world"
    )
    check.add_argument("--split", help="split of the episode (default: the first split that has it)")
    check.add_argument("--turn", type=int, choices=(1, 2), help="turn of the episode (default: both)")
    check.set_defaults(command=_check)


def _show(arguments: argparse.Namespace) -> None:
    from arramon_dataset.pictures.episode import show, show_section

    if (arguments.episode is None) == (arguments.section is None):
        raise BadInput("expected either an episode or a section to show: `show 8900`, or `show --section 1`")
    draw, name = (show, arguments.episode) if arguments.section is None else (show_section, arguments.section)
    for path in draw(arguments.data, name, arguments.split, arguments.output):
        print(path)


def _stats(arguments: argparse.Namespace) -> None:
    from arramon_dataset.statistics.command import as_json, statistics_of
    from arramon_dataset.statistics.plots import write_plots
    from arramon_dataset.statistics.table import as_text

    figures = statistics_of(arguments.data, arguments.split, arguments.lang, sample=arguments.sample)
    pictures = write_plots(figures, arguments.output) if arguments.output else []
    if arguments.json:
        print(json.dumps(as_json(figures), ensure_ascii=False, indent=1))
        return
    print(*as_text(figures), *pictures, sep="\n")


def _check(arguments: argparse.Namespace) -> int:
    """Print the failed checks of each text; return 1 if any of them blocks its text."""
    blocked = False
    for text, failures in _checked(arguments):
        print(text)
        for failure in failures:
            print(f"  {failure}")
        if not failures:
            print("  passes every check")
        blocked |= any_blocks(failures)
    return int(blocked)


def _checked(arguments: argparse.Namespace) -> Iterator[tuple[str, tuple[Failure, ...]]]:
    """Yield each text with the checks that it fails."""
    given = arguments.lang, arguments.phase, arguments.target, arguments.first_turn
    if arguments.episode is None:
        if arguments.split is not None or arguments.turn is not None:
            raise BadInput(
                "--split and --turn select the world of an episode: give its id with --episode, or leave them out"
            )
        yield from check_texts(arguments.texts or (line for line in map(str.strip, sys.stdin) if line), *given)
        return
    if arguments.phase != "navigation":
        raise BadInput("--episode checks what is in the streets: expected --phase navigation")
    from arramon_dataset.world_check import check_in_world

    named = arguments.data, arguments.episode, arguments.split, arguments.turn, arguments.lang
    for text, turn, absent in check_in_world(*named, arguments.texts):
        ((_, failures),) = check_texts([text], *given)
        yield f"turn {turn}: {text}", (*failures, *absent)
