"""Command-line options of `arramon-client`, and the command that resumes a run."""

import argparse
import shlex
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from arramon_client.commands.base import parse as parse_known
from arramon_client.errors import UsageError
from arramon_client.plugin.arguments import parse_arguments
from arramon_client.run_settings import ENCODINGS
from arramon_client.settings import ON_FAILURE
from arramon_client.transport.access import add_access
from arramon_client.transport.incoming import RUN_ID
from arramon_client.world import SENSORS

COMMANDS = {
    "play": "play episodes yourself, in the browser",
    "account": "show your account on a server: name, role, limits and current usage",
    "runs": "list your runs",
    "cancel": "cancel runs; their unfinished episodes are given up",
    "notes": "print what a run's agent noted beside its steps",
    "leaderboard": "show the ranking of a split's published runs",
    "mcp": "let an assistant or editor play, by the Model Context Protocol",
    "publish": "put a run on the leaderboard",
    "report": "show scores by what the turns ask for: what runs can and cannot do",
    "withdraw": "take a run off the leaderboard",
    "epochs": "list the epochs of a server's hidden splits, or compare agents on two of them",
    "conformance": "check that a server implements the protocol correctly",
    "verify": "check a receipt: its signature, the host's key and the actions that were sent",
}
"""One-line descriptions of the subcommands, by name."""

EPILOG = """\
other commands, each with a --help of its own:
{commands}

exit status: 0 success; 1 error; 2 wrong usage, or the agent cannot be loaded;
3 the agent failed in some episodes, or the run was stopped because it failed;
4 the agent stopped the run, for example at a limit: the run can be resumed;
130, 143 or 129 stopped by Ctrl-C, SIGTERM or SIGHUP: the run can be resumed"""


def parser() -> argparse.ArgumentParser:
    """Return the argument parser of `arramon-client`."""
    made = argparse.ArgumentParser(
        prog="arramon-client",
        allow_abbrev=False,
        description="Play ArraMon episodes with an agent, on a remote or an embedded server, and show the scores.",
        usage="arramon-client --agent A --lang L [options]\n       arramon-client COMMAND [options]",
        epilog=EPILOG.format(commands="\n".join(f"  {word:<12} {does}" for word, does in COMMANDS.items())),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    made.add_argument("--version", action="version", version=f"arramon-client {version('arramon-client')}")
    add = made.add_argument
    add("--agent", metavar="A", help="module (agents.random_walk), file (./my_agent.py), either with :Class; required")
    add(
        "--agent-arg",
        action="append",
        default=[],
        dest="agent_arguments",
        metavar="NAME=VALUE",
        help="argument for the agent's constructor, e.g. beam=4; repeatable. Published with the run",
    )
    add(
        "--agent-processes",
        type=positive,
        metavar="N",
        help="copies of the agent, in processes of their own (default: one for each core if the agent asks for it, as "
        "agents.vl_map does; otherwise the agent runs in the client's process)",
    )
    add("--code-url", default="", metavar="URL", help="address of the agent's code. Published with the run")
    add("--code-commit", default="", metavar="ID", help="full id of the code's commit, with --code-url")
    add("--code-image", default="", metavar="DIGEST", help="digest of the agent's container image: sha256:...")
    add(
        "--lang",
        type=_languages,
        default=(),
        dest="languages",
        metavar="L",
        help="language of the instructions: en, hi, or te, a preview that no native speaker has reviewed; en,hi plays "
        "a run in each (required unless --resume)",
    )
    add("--split", metavar="S", help="split to play (default: the server's only split with that language)")
    add("--server", metavar="ADDR", help="host:port or unix:/path (default: start an embedded server)")
    add(
        "--data",
        type=Path,
        metavar="DIR",
        help="data folder of the embedded server (default: $ARRAMON_DATA, or ./arramon-data)",
    )
    add("--workers", type=positive, metavar="N", help="worker processes of the embedded server (default: 1)")
    add(
        "--episodes",
        type=positive,
        metavar="N",
        help="play the first N episodes in the split's fixed order (default: all)",
    )
    add(
        "--episode",
        action="append",
        default=[],
        metavar="ID",
        help="play this episode; repeatable (open splits only)",
    )
    add(
        "--parallel",
        type=positive,
        metavar="K",
        help="episodes played in parallel (default: 8 for each copy of the agent)",
    )
    listed = ",".join(SENSORS)
    add("--sensors", type=_sensors, metavar="LIST", help=f"comma-separated: {listed}; or none (default: the agent's)")
    add("--image-size", type=positive, metavar="N", help="side length of the images in pixels (default: the server's)")
    add(
        "--encoding",
        choices=tuple(ENCODINGS),
        help="encoding of images (default: shared, else raw, on this machine; zstd, also lossless, elsewhere)",
    )
    add("--quality", type=_quality, metavar="Q", help="quality of JPEG images, 1 to 100 (default: the server's)")
    add(
        "--output",
        type=Path,
        default=Path("arramon-results"),
        metavar="DIR",
        help="folder for results (default: %(default)s)",
    )
    add(
        "--record",
        type=Path,
        metavar="DIR",
        help="record frames, actions and maps to this folder, as files and as web pages",
    )
    add(
        "--resume",
        type=_run_ids,
        default=(),
        metavar="RUN",
        help="resume a run, with the language, split, sensors and episodes it was created with; with several languages "
        "RUN,RUN; runs that were not created yet are left out",
    )
    add("--dry-run", action="store_true", help="test the setup: play two episodes of an open split instead")
    add("--keep-going", action="store_true", help="do not stop when the agent fails: give up the episode and go on")
    add(
        "--retries",
        type=_count,
        metavar="N",
        help="how often a failed act of an agent that waits (async) is repeated for the same observation (default: 2)",
    )
    add(
        "--on-failure",
        choices=ON_FAILURE,
        help="what follows when an agent that waits still fails: stop the run, which can be resumed (default), or give "
        "up the episode (default with --keep-going)",
    )
    add(
        "--participant",
        default="",
        metavar="NAME",
        help="participant's name to record with the run (default: anonymous)",
    )
    add("--quiet", action="store_true", help="show no progress")
    add("--json", action="store_true", help="print the results as JSON, and nothing else to standard output")
    add_access(made)
    return made


def parse(argv: Sequence[str]) -> argparse.Namespace:
    """Return the parsed and checked arguments.

    Raises:
        SystemExit: if they are wrong, with status 2, after printing the reason.
    """
    made = parser()
    options, others = made.parse_known_args(argv)
    misplaced = next((word for word in others if word in COMMANDS), None)
    if misplaced is not None and options.agent is None:
        made.error(f"the command comes first: arramon-client {misplaced} ...")
    arguments = parse_known(made, argv)
    if arguments.agent is None:
        made.error("the following arguments are required: --agent")
    if not arguments.resume and not arguments.languages:
        made.error("--lang is required: the language of the instructions, e.g. --lang en")
    if arguments.episodes is not None and arguments.episode:
        made.error("--episodes and --episode cannot be used together: one gives a number, the other names episodes")
    twice = next((each for each in arguments.episode if arguments.episode.count(each) > 1), None)
    if twice is not None:
        made.error(f"--episode {twice} is given twice; a run plays an episode only once")
    try:
        arguments.agent_arguments = parse_arguments(arguments.agent_arguments)
    except UsageError as error:
        made.error(str(error))
    if arguments.languages and len(arguments.resume) > len(arguments.languages):
        made.error(f"--resume names {len(arguments.resume)} runs, more than --lang names languages")
    if arguments.resume and arguments.dry_run:
        made.error("--dry-run tests the setup of a new run, and cannot be used together with --resume")
    _check_server(made, arguments)
    return arguments


def _check_server(made: argparse.ArgumentParser, arguments: argparse.Namespace) -> None:
    """Check that options for an embedded server are not combined with --server, and the other way round."""
    for option, value in (("--data", arguments.data), ("--workers", arguments.workers)):
        if arguments.server is not None and value is not None:
            made.error(f"{option} applies to the embedded server, and cannot be used together with --server")
    for option in ("token", "token_file", "tls", "tls_ca"):
        if arguments.server is None and getattr(arguments, option) is not None:
            made.error(f"--{option.replace('_', '-')} requires --server: the embedded server does not use it")


HIGHER = "HIGHER"
"""Printed in place of a limit that was reached: as it was, it would stop the run at once; without it, nothing would."""


def resume_command(argv: Sequence[str], run_id: str, limit: str = "") -> str:
    """Return the command line that resumes a run, without the token, to be printed.

    Args:
        argv: the arguments that started the run, as typed.
        run_id: the run's id, or several, separated by commas.
        limit: the agent's argument that held a limit that was reached; empty if none was.
    """
    kept = []
    skip = False
    for argument in argv:
        if skip or argument.startswith(("--resume=", "--token=")):
            skip = False
        elif argument in ("--resume", "--token"):
            skip = True
        else:
            option, found, _ = argument.rpartition(f"{limit}=") if limit else ("", "", "")
            reached = found and option in ("", "--agent-arg=")
            kept.append(f"{option}{limit}={HIGHER}" if reached else argument)
    return shlex.join(["arramon-client", *kept, "--resume", run_id])


def positive(text: str) -> int:
    """Parse a whole number above 0.

    Raises:
        argparse.ArgumentTypeError: if the text is not one.
    """
    number = int(text) if text.isdecimal() else 0
    if number < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number above 0")
    return number


def _count(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number")
    return int(text)


def _quality(text: str) -> int:
    number = int(text) if text.isdecimal() else 0
    if not 1 <= number <= 100:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from 1 to 100")
    return number


def _languages(text: str) -> tuple[str, ...]:
    codes = tuple(text.split(","))
    if not all(codes) or len(set(codes)) < len(codes):
        raise argparse.ArgumentTypeError(f"{text!r} is not a list of different languages, such as en,hi")
    return codes


def _run_ids(text: str) -> tuple[str, ...]:
    ids = tuple(text.split(","))
    for each in ids:
        if not RUN_ID.fullmatch(each):
            raise argparse.ArgumentTypeError(f"{each!r} is not the id of a run, expected 32 hexadecimal digits")
    if len(set(ids)) < len(ids):
        raise argparse.ArgumentTypeError(f"{text!r} names a run twice")
    return ids


def _sensors(text: str) -> tuple[str, ...]:
    if text == "none":
        return ()
    names = tuple(text.split(","))
    unknown = [name for name in names if name not in SENSORS]
    if unknown:
        raise argparse.ArgumentTypeError(
            f"unknown sensor {', '.join(map(repr, unknown))}, expected some of {', '.join(SENSORS)}, or none"
        )
    return names
