"""The command `arramon-client`: play a run with an agent and show its scores, or run one of the subcommands."""

import os
import sys
from collections.abc import Sequence

from arramon_client import arguments
from arramon_client.commands import account, epochs, leaderboard, mcp, notes, play_page, report, runs, verify
from arramon_client.commands.base import ERROR, USAGE, nearest
from arramon_client.commands.play import PlayCommand
from arramon_client.commands.single_run import AGENT_FAILED, AGENT_STOPPED
from arramon_client.conformance import command as conformance
from arramon_client.errors import (
    AgentError,
    AgentLoadError,
    AgentStoppedError,
    ArramonClientError,
    ServerUnreachableError,
    StopRun,
    UsageError,
)
from arramon_client.stopping import describe, status_of, stopped_by_signals

COMMANDS = {
    "account": account.main,
    "cancel": runs.cancel,
    "conformance": conformance.main,
    "epochs": epochs.main,
    "leaderboard": leaderboard.show,
    "mcp": mcp.main,
    "notes": notes.main,
    "play": play_page.main,
    "publish": leaderboard.publish,
    "report": report.main,
    "runs": runs.show,
    "verify": verify.main,
    "withdraw": leaderboard.withdraw,
}
"""Functions of the subcommands, by name; each takes the arguments after the name."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command and return its exit status.

    Returns:
        0 success, 1 error, 2 usage, 3 the agent failed, 4 the agent stopped the run; 128 plus the signal's number after
        a signal, such as 143 for SIGTERM.
    """
    argv = sys.argv[1:] if argv is None else argv
    os.environ.setdefault("GRPC_VERBOSITY", "NONE")  # The client explains connection errors itself.
    with stopped_by_signals():
        if argv and argv[0] in COMMANDS:
            return COMMANDS[argv[0]](argv[1:])
        if argv and not argv[0].startswith("-"):
            return _report_unknown(argv[0])
        return _play(argv)


def _report_unknown(word: str) -> int:
    """Print an error for an unknown command."""
    hint = nearest(word, COMMANDS) or f"; expected {', '.join(COMMANDS)}, or options such as --agent (see --help)"
    print(f"arramon-client: unknown command {word!r}{hint}", file=sys.stderr)
    return USAGE


def _play(argv: Sequence[str]) -> int:
    try:
        options = arguments.parse(argv)
    except SystemExit as leaving:
        return leaving.code if isinstance(leaving.code, int) else USAGE
    command = PlayCommand(options, argv)
    try:
        return command.run()
    except KeyboardInterrupt as stop:
        command.say(describe(stop))
        command.hint()
        return status_of(stop)
    except StopRun as stop:
        command.say(f"the agent stopped the run: {stop or 'no reason was given'}")
        command.hint(stop.limit)
        return AGENT_STOPPED
    except ArramonClientError as error:
        command.say(f"error: {error}")
        if isinstance(error, AgentError) and error.details:
            command.say(error.details)
        if command.playing or isinstance(error, ServerUnreachableError):
            command.hint()
        if isinstance(error, AgentStoppedError):
            what = "fix the agent" if error.details else "remove the cause"
            command.say(f"{what}, then resume; with --keep-going, episodes that fail are given up and the run goes on")
            return AGENT_FAILED
        return USAGE if isinstance(error, UsageError | AgentLoadError) else ERROR
