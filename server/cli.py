"""The command line of the server: `arramon-server serve`, `import-release`, `generate`, `show`, `stats` and others."""

import argparse
import json
import logging
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from lang.quality import PHASES, is_blocked
from server import __version__
from server.checking import check_texts
from server.config import LISTEN, MAX_WORKERS, Config
from server.episodes.importing import import_release
from server.episodes.splits import Split, read_splits
from server.errors import ArraMonError, BadInput
from server.health import check
from server.runs.journal import Journal
from server.serving import compile_camera, serve
from server.sim.cameras import CAMERAS
from server.sim.rules import STEPS_PER_PHASE, Limits
from server.workers import serve_with_workers


def main(argv: Sequence[str] | None = None) -> int:
    """Runs a command; returns the exit status: 0 fine, 1 something was wrong and was said, 2 usage, 130 interrupted."""
    arguments = _parser().parse_args(argv)
    logging.basicConfig(level=arguments.log.upper(), format="%(asctime)s %(levelname)s %(name)s: %(message)s")
    try:
        status: int | None = arguments.command(arguments)
    except ArraMonError as error:
        print(f"arramon-server: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("arramon-server: interrupted", file=sys.stderr)
        return 130
    return status or 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="arramon-server", description="The ArraMon evaluation server.")
    parser.add_argument("--version", action="version", version=f"arramon-server {__version__}")
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument(
        "--data",
        type=Path,
        default=Path(os.environ.get("ARRAMON_DATA", "arramon-data")),
        help="folder with episodes and journal (default: $ARRAMON_DATA or ./arramon-data)",
    )
    common.add_argument(
        "--log", default="warning", choices=("debug", "info", "warning", "error"), help="how much to log"
    )
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")

    serve_ = commands.add_parser("serve", parents=[common], help="serve the episodes of the data folder")
    serve_.add_argument("--listen", default=LISTEN, help="host:port or unix:/path (default: %(default)s)")
    serve_.add_argument("--journal", default="", help="database URL (default: SQLite in the data folder)")
    serve_.add_argument(
        "--steps", type=int, default=STEPS_PER_PHASE, help="step limit of a phase (default: %(default)s)"
    )
    serve_.add_argument(
        "--fsync",
        action=argparse.BooleanOptionalAction,
        default=True,
        help="wait for the disk with every step, so that it outlives a loss of power, not only the end of a process",
    )
    serve_.add_argument(
        "--camera",
        default=CAMERAS[0],
        choices=CAMERAS,
        help="what draws: the fast one, or pybullet's (default: %(default)s)",
    )
    serve_.add_argument("--workers", type=int, default=1, help="processes that serve (default: %(default)s)")
    # How `workers` starts each of them.
    serve_.add_argument("--shared-port", action="store_true", help=argparse.SUPPRESS)
    serve_.add_argument("--own-address", default="", help=argparse.SUPPRESS)
    serve_.set_defaults(command=_serve)

    health = commands.add_parser("health", parents=[common], help="ask a server whether it serves; status 1 if not")
    health.add_argument("--address", default=LISTEN, help="host:port or unix:/path (default: %(default)s)")
    health.set_defaults(command=_health)

    import_ = commands.add_parser("import-release", parents=[common], help="bring in files of the official release")
    import_.add_argument(
        "files", nargs="+", type=Path, metavar="FILE", help="such as val_seen.json, val_seen_hindi.json"
    )
    import_.add_argument("--split", help="name of the split (default: from the file's name)")
    import_.add_argument("--lang", help="language of the instructions (default: from their script)")
    import_.add_argument("--hidden", action="store_true", help="keep targets, goals and paths on the server")
    import_.set_defaults(command=_import)

    generate = commands.add_parser("generate", parents=[common], help="make the data set, or a part of it")
    generate.add_argument("--split", nargs="+", metavar="S", help="such as val_unseen (default: all four)")
    generate.add_argument(
        "--scale", type=float, default=1.0, help="share of each split's episodes (default: %(default)s)"
    )
    generate.add_argument(
        "--seed", type=int, default=1, help="draws all but a hidden split, which the host's secret draws (default: 1)"
    )
    generate.add_argument("--jobs", type=int, default=0, help="processes (default: one a core)")
    generate.set_defaults(command=_generate)

    show = commands.add_parser("show", parents=[common], help="draw an episode: a map, and what the agent sees")
    show.add_argument("episode", help="its id, such as 8900")
    show.add_argument("--split", help="where it is (default: the first split that has it)")
    show.add_argument("--output", type=Path, default=Path(), help="folder for the pictures (default: here)")
    show.set_defaults(command=_show)

    stats = commands.add_parser("stats", parents=[common], help="what the instructions and paths are like, in figures")
    stats.add_argument("--split", nargs="+", default=(), metavar="S", help="splits, side by side (default: all)")
    stats.add_argument("--lang", nargs="+", default=(), metavar="L", help="languages (default: all that there are)")
    stats.add_argument(
        "--sample", type=int, default=2000, metavar="N", help="instructions for the diversity (default: %(default)s)"
    )
    stats.add_argument("--output", type=Path, metavar="FOLDER", help="draw the figures too, into this folder")
    stats.add_argument("--json", action="store_true", help="print JSON in place of tables")
    stats.set_defaults(command=_stats)
    _add_check(commands, common)
    return parser


def _add_check(
    commands: "argparse._SubParsersAction[argparse.ArgumentParser]", common: argparse.ArgumentParser
) -> None:
    check = commands.add_parser("check-instruction", parents=[common], help="say which quality checks a text fails")
    check.add_argument("texts", nargs="*", metavar="TEXT", help="an instruction (default: each line of standard input)")
    check.add_argument("--lang", default="en", help="language it should be in (default: %(default)s)")
    check.add_argument("--phase", required=True, choices=PHASES, help="what it instructs")
    check.add_argument("--target", default="", metavar="WORDS", help="object it must name: 'dotted brown bucket'")
    check.add_argument(
        "--first-turn", type=float, default=0.0, metavar="DEGREES", help="how far the path turns before its first step"
    )
    check.set_defaults(command=_check)


def _serve(arguments: argparse.Namespace) -> None:
    config = Config(
        data=arguments.data,
        listen=arguments.listen,
        shared_port=arguments.shared_port,
        own_address=arguments.own_address,
        journal=arguments.journal,
        camera=arguments.camera,
        fsync=arguments.fsync,
        limits=Limits(arguments.steps),
    )
    if not 1 <= arguments.workers <= MAX_WORKERS:
        raise BadInput(f"{arguments.workers} workers were asked for, expected 1 to {MAX_WORKERS}")
    splits = read_splits(config.data)
    for split in splits.values():
        print(_describe(split), flush=True)

    def say(line: str) -> None:
        print(line, flush=True)

    if arguments.workers == 1:
        serve(config, splits, say)
        return
    compile_camera(config, say)  # once, as is the journal made or migrated, before all workers come to it
    Journal(config.journal_url).close()
    own = [
        "--data",
        str(config.data),
        "--camera",
        config.camera,
        "--journal",
        config.journal,
        "--steps",
        str(config.limits.steps_per_phase),
    ]
    own += [] if config.fsync else ["--no-fsync"]
    serve_with_workers(arguments.workers, config.listen, [*own, "--log", arguments.log], say)


def _health(arguments: argparse.Namespace) -> None:
    check(arguments.address)
    print(f"{arguments.address} serves")


def _import(arguments: argparse.Namespace) -> None:
    for split in import_release(
        arguments.files, arguments.data, split=arguments.split, language=arguments.lang, hidden=arguments.hidden
    ):
        print(_describe(split))


def _generate(arguments: argparse.Namespace) -> None:
    from server.generating import generate_splits

    def tell(line: str) -> None:
        print(line, file=sys.stderr, flush=True)

    for split in generate_splits(
        arguments.data,
        arguments.split,
        scale=arguments.scale,
        seed=arguments.seed,
        jobs=arguments.jobs,
        tell=tell,
    ):
        print(_describe(split))


def _show(arguments: argparse.Namespace) -> None:
    from server.show.episode import show

    for path in show(arguments.data, arguments.episode, arguments.split, arguments.output):
        print(path)


def _stats(arguments: argparse.Namespace) -> None:
    from server.stats.command import as_json, figures_of
    from server.stats.plots import write_plots
    from server.stats.table import as_text

    figures = figures_of(arguments.data, arguments.split, arguments.lang, sample=arguments.sample)
    pictures = write_plots(figures, arguments.output) if arguments.output else []
    if arguments.json:
        print(json.dumps(as_json(figures), ensure_ascii=False, indent=1))
        return
    try:
        print(*as_text(figures), *pictures, sep="\n", flush=True)
    except BrokenPipeError:  # Read by `head` or a pager that was left: nothing is wrong.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _check(arguments: argparse.Namespace) -> int:
    """Says each text's failed checks; 1 if one of them blocks its text."""
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


def _describe(split: Split) -> str:
    languages = ", ".join(f"{count} in {code}" for code, count in split.languages.items())
    kind = "hidden" if split.hidden else "open"
    return f"split {split.name} ({kind}): {languages}; {len(split.sections)} sections; data {split.data_hash[:12]}"
