"""The commands `show`, `stats` and `check-instruction`: inspection of episodes and instructions."""

import argparse
import json
import sys
from pathlib import Path

from lang.quality import PHASES, is_blocked
from server.commands import Commands
from server.dataset.instruction_check import check_texts


def add(commands: Commands, common: argparse.ArgumentParser) -> None:
    """Add all three commands."""
    show = commands.add_parser("show", parents=[common], help="draw an episode: a map, and the agent's views")
    show.add_argument("episode", help="id of the episode, such as 8900")
    show.add_argument("--split", help="split of the episode (default: the first split that has it)")
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
    check.add_argument("texts", nargs="*", metavar="TEXT", help="an instruction (default: each line of standard input)")
    check.add_argument("--lang", default="en", help="language of the text (default: %(default)s)")
    check.add_argument("--phase", required=True, choices=PHASES, help="phase that it instructs")
    check.add_argument("--target", default="", metavar="WORDS", help="object it must name: 'dotted brown bucket'")
    check.add_argument(
        "--first-turn",
        type=float,
        default=0.0,
        metavar="DEGREES",
        help="angle by which the path turns before its first step",
    )
    check.set_defaults(command=_check)


def _show(arguments: argparse.Namespace) -> None:
    from server.dataset.pictures.episode import show

    for path in show(arguments.data, arguments.episode, arguments.split, arguments.output):
        print(path)


def _stats(arguments: argparse.Namespace) -> None:
    from server.dataset.statistics.command import as_json, figures_of
    from server.dataset.statistics.plots import write_plots
    from server.dataset.statistics.table import as_text

    figures = figures_of(arguments.data, arguments.split, arguments.lang, sample=arguments.sample)
    pictures = write_plots(figures, arguments.output) if arguments.output else []
    if arguments.json:
        print(json.dumps(as_json(figures), ensure_ascii=False, indent=1))
        return
    print(*as_text(figures), *pictures, sep="\n")


def _check(arguments: argparse.Namespace) -> int:
    """Print the failed checks of each text; return 1 if one of them blocks its text."""
    texts = arguments.texts or (line for line in map(str.strip, sys.stdin) if line)
    blocked = False
    for text, failures in check_texts(texts, arguments.lang, arguments.phase, arguments.target, arguments.first_turn):
        print(text)
        for failure in failures:
            print(f"  {failure}")
        if not failures:
            print("  passes every check")
        blocked |= is_blocked(failures)
    return int(blocked)
