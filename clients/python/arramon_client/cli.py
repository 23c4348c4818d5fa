"""The command `arramon-client`: play a run with an agent and show its scores, or run one of the subcommands."""

import argparse
import os
import shlex
import sys
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, nullcontext
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from arramon.v1 import evaluation_pb2
from arramon_client import arguments, dry_run, receipts, results, run_settings
from arramon_client.agent import Agent
from arramon_client.commands import account, epochs, leaderboard, report, runs, verify
from arramon_client.commands.base import ERROR, INTERRUPTED, SUCCESS, USAGE
from arramon_client.conformance import command as conformance
from arramon_client.errors import (
    AgentError,
    AgentLoadError,
    AgentStoppedError,
    ArramonClientError,
    ReceiptError,
    UsageError,
)
from arramon_client.local.embedded import SERVER, EmbeddedServer, check_installed, default_data, embedded_server
from arramon_client.local.first_episodes import SPLIT, holds_episodes, make_episodes
from arramon_client.multi_stream import play_streams
from arramon_client.play import Outcome, Settings
from arramon_client.plugin.arguments import parse_value
from arramon_client.plugin.loader import load_agent
from arramon_client.progress import progress_display
from arramon_client.recording.recorder import Recording
from arramon_client.transport.access import Access, access_of
from arramon_client.transport.connection import Server, call, connect, give_up
from arramon_client.transport.retry import PATIENCE, Retry, ask

AGENT_FAILED = 3

WARNINGS = 5
"""Number of episodes that differ from the receipt for which a warning each is printed."""

COMMANDS = {
    "account": account.main,
    "cancel": runs.cancel,
    "conformance": conformance.main,
    "epochs": epochs.main,
    "leaderboard": leaderboard.show,
    "publish": leaderboard.publish,
    "report": report.main,
    "runs": runs.show,
    "verify": verify.main,
    "withdraw": leaderboard.withdraw,
}
"""Subcommands by name; each is called with the arguments that follow its name."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command and return its exit status: 0 success, 1 error, 2 usage, 3 the agent failed, 130 interrupted."""
    argv = sys.argv[1:] if argv is None else argv
    os.environ.setdefault("GRPC_VERBOSITY", "NONE")  # The client explains connection errors itself.
    if argv and argv[0] in COMMANDS:
        return COMMANDS[argv[0]](argv[1:])
    try:
        options = arguments.parse(argv)
    except SystemExit as leaving:
        return leaving.code if isinstance(leaving.code, int) else USAGE
    client = _Client(options, argv, Console(stderr=True))
    try:
        return client.run()
    except KeyboardInterrupt:
        client.say("interrupted")
        client.hint()
        return INTERRUPTED
    except ArramonClientError as error:
        client.say(f"error: {error}")
        if isinstance(error, AgentError) and error.details:
            client.say(error.details)
        client.hint()
        if isinstance(error, AgentStoppedError):
            client.say(
                "fix the agent, then resume; with --keep-going, episodes that fail are given up and the run goes on"
            )
            return AGENT_FAILED
        return USAGE if isinstance(error, UsageError | AgentLoadError) else ERROR


@dataclass
class _Client:
    """One invocation of the command.

    Attributes:
        options: the parsed options.
        argv: the arguments as typed.
        console: where everything except the scores is written.
        unfinished: id of the run to resume; empty before it is created and once it is complete.
        recording: the run's recording, if requested.
    """

    options: argparse.Namespace
    argv: Sequence[str]
    console: Console
    unfinished: str = ""
    recording: Recording | None = None

    def say(self, text: str) -> None:
        """Write a line for the participant without wrapping, so that commands and paths can be copied."""
        self.console.print(text, markup=False, highlight=False, soft_wrap=True)

    @property
    def output(self) -> Path:
        """The folder for results; a dry run has a subfolder of its own."""
        folder: Path = self.options.output
        return folder / dry_run.FOLDER if self.options.dry_run else folder

    def hint(self) -> None:
        """Print the command that resumes an unfinished run."""
        if self.unfinished:
            self.say(f"the run is saved; resume it with\n  {arguments.resume_command(self.argv, self.unfinished)}")

    def run(self) -> int:
        """Play the run, show its scores and write its files; return the exit status.

        Raises:
            ArramonClientError: any error whose message is for the participant.
        """
        options = self.options
        agent = load_agent(options.agent, {name: parse_value(typed) for name, typed in options.agent_arguments.items()})
        results.check_output(self.output)
        if options.record is not None:
            results.check_output(options.record, "the recording")
        with ExitStack() as stack:
            revive: Callable[[], None] = lambda: None  # noqa: E731 - replaced if a server is embedded
            address, access, unreachable = options.server, Access(), give_up
            if address is None:
                embedded = stack.enter_context(self._embedded())
                address, revive = embedded.address, embedded.revive
            else:
                access = access_of(options)
                if options.resume:  # The run's server may be restarting.
                    unreachable = Retry(options.resume, PATIENCE, self.say).wait_for
            server = stack.enter_context(connect(address, access, unreachable=unreachable))
            run = self._resumed(server, agent) if options.resume else self._created(server, agent)
            if options.dry_run:
                stack.enter_context(dry_run.cancelled_unless_played(server, run.run_id))
            outcome = None
            if run.state == evaluation_pb2.RUN_STATE_RUNNING:
                outcome = self._play(server, run, agent, revive)
            request = evaluation_pb2.GetReportRequest(run_id=run.run_id)
            retry = Retry(run.run_id, PATIENCE, self.say)
            report = ask(server.stub.GetReport, request, server.address, retry, revive)
            receipt = self._receipt(server, run.run_id, retry, revive)
            public_key = server.info.public_key
        status = self._show(report, outcome)
        if receipt is not None:
            self._keep(receipt, run.run_id, public_key, outcome)
        if options.dry_run:
            failed = "fix the agent before the real run" if status == AGENT_FAILED else "see the errors above"
            verdict = "no errors" if status == SUCCESS else failed
            self.say(f"this was a dry run: {verdict}. Run the same command without --dry-run for the real run")
        return status

    def _embedded(self) -> AbstractContextManager[EmbeddedServer]:
        # Only this client uses the server: a step must survive the end of the process, but not a loss of power.
        # Clocks are off, so that an agent in a debugger does not time out.
        options = ("--no-fsync", "--workers", str(self.options.workers or 1), "--step-seconds", "0")
        data = self.options.data or default_data()
        if not (self.options.split or self.options.resume or holds_episodes(data)):
            check_installed(SERVER)
            self.say(f"no episodes in {data} yet: generating a small part of {SPLIT} (only once)")
            make_episodes(data, quiet=self.options.quiet)
        return embedded_server(data, options=options, notify=self.say)

    def _created(self, server: Server, agent: Agent) -> evaluation_pb2.Run:
        options = self.options
        split = run_settings.choose_split(server.info, options.lang, options.split)
        if options.episode and split.hidden:
            raise UsageError(
                f"split {split.name!r} is hidden and must be played whole; --episode requires an open split"
            )
        sensors = run_settings.choose_sensors(agent, options.sensors, split)
        episodes, named = options.episodes or 0, options.episode
        if options.dry_run:
            split = dry_run.choose_split(server.info, split, options.lang, sensors)
            few = min(dry_run.EPISODES, split.episodes[options.lang], options.episodes or dry_run.EPISODES)
            episodes, named = (0 if named else few), named[: dry_run.EPISODES]
        request = evaluation_pb2.CreateRunRequest(
            agent=agent_name(agent, options.agent),
            split=split.name,
            language=options.lang,
            sensors=sensors,
            episodes=episodes,
            participant=options.participant,
            episode_ids=named,
            agent_arguments=[
                evaluation_pb2.AgentArgument(name=name, value=typed) for name, typed in options.agent_arguments.items()
            ],
            code=_code(options),
        )
        self._settings(server)  # Fail before creating a run that could not be played.
        return call(server.stub.CreateRun, request, server.address)

    def _resumed(self, server: Server, agent: Agent) -> evaluation_pb2.Run:
        options = self.options
        request = evaluation_pb2.GetRunRequest(run_id=options.resume)
        retry = Retry(options.resume, PATIENCE, self.say)  # The server may become unreachable between two calls.
        run = ask(server.stub.GetRun, request, server.address, retry)
        for option, asked, kept in (
            ("--agent", agent_name(agent, options.agent), run.agent),
            ("--lang", options.lang, run.language),
            ("--split", options.split, run.split),
            ("--sensors", options.sensors and tuple(sorted(options.sensors)), tuple(sorted(run.sensors))),
        ):
            if asked is not None and asked != kept:
                raise UsageError(f"run {run.run_id} was started with {option} {kept}, not {asked}")
        code = _code(options)
        if code is not None and code != run.code:
            raise UsageError(f"run {run.run_id} was started with other code than --code-url and the like name")
        kept_arguments = {argument.name: argument.value for argument in run.agent_arguments}
        if options.agent_arguments != kept_arguments:
            begun, asked = (_typed(each) or "no --agent-arg" for each in (kept_arguments, options.agent_arguments))
            raise UsageError(f"run {run.run_id} was started with {begun}, not with {asked}")
        return run

    def _settings(self, server: Server) -> Settings:
        encoding = run_settings.choose_encoding(server.info, self.options.encoding, server.address)
        return Settings(
            parallel=run_settings.choose_parallel(server.info, self.options.parallel),
            encoding=encoding,
            jpeg_quality=run_settings.choose_jpeg_quality(encoding, self.options.quality),
            image_size=run_settings.choose_image_size(server.info, self.options.image_size),
            resume=self.options.resume is not None,
            keep_going=self.options.keep_going or self.options.dry_run,  # Episodes of a dry run do not count.
        )

    def _play(self, server: Server, run: evaluation_pb2.Run, agent: Agent, revive: Callable[[], None]) -> Outcome:
        settings = self._settings(server)
        kind = "run" if not self.options.dry_run else "dry run"
        self.unfinished = run.run_id if not self.options.dry_run else ""
        self.say(
            f"{kind} {run.run_id}: {run.agent} plays {run.episodes} episodes of {run.split}, {run.language}, "
            f"{settings.parallel} in parallel"
        )
        started = time.monotonic()
        with (
            self._recording(run) as self.recording,
            progress_display(self.console, quiet=self.options.quiet) as progress,
        ):
            outcome = play_streams(
                server,
                run,
                agent,
                settings,
                notify=self.say,
                progress=progress,
                revive=revive,
                recording=self.recording,
            )
            seconds = time.monotonic() - started
        self.say(f"{outcome.steps} steps in {seconds:.1f} s, {outcome.steps / max(seconds, 1e-9):.0f} steps/s")
        return outcome

    def _recording(self, run: evaluation_pb2.Run) -> AbstractContextManager[Recording | None]:
        if self.options.record is None:
            return nullcontext()
        return Recording(self.options.record, run, self.say)

    def _receipt(
        self, server: Server, run_id: str, retry: Retry, revive: Callable[[], None]
    ) -> evaluation_pb2.Receipt | None:
        request = evaluation_pb2.GetReceiptRequest(run_id=run_id)
        try:
            return ask(server.stub.GetReceipt, request, server.address, retry, revive)
        except ArramonClientError as error:  # The scores are still shown.
            self.say(f"no receipt: {error}")
            return None

    def _keep(self, receipt: evaluation_pb2.Receipt, run_id: str, key: bytes, outcome: Outcome | None) -> None:
        """Write the receipt to its file, and check it against the server's key and the actions that were sent."""
        path = receipts.write_receipt(receipt, run_id, self.output)
        try:
            kept = receipts.read_receipt(path)
            receipts.check_key(kept, key, "the server's key")
        except ReceiptError as error:
            self.say(f"warning: {error}")
        else:
            compared = receipts.compare_actions(kept, outcome.actions if outcome is not None else {})
            for difference in compared.differences[:WARNINGS]:
                self.say(f"warning: {difference}")
            if len(compared.differences) > WARNINGS:
                more = len(compared.differences) - WARNINGS
                self.say(f"warning: {more} more episodes differ; to list them all: arramon-client verify {path}")
        Console().print(f"receipt: {path}", markup=False, highlight=False, soft_wrap=True)

    def _show(self, report: evaluation_pb2.Report, outcome: Outcome | None) -> int:
        failures = outcome.failures if outcome is not None else ()
        scores = Console()
        scores.width = max(scores.width, results.TABLE_WIDTH)
        scores.print(results.score_table(report))
        scores.print(report.signature, markup=False, highlight=False, soft_wrap=True)
        sent = outcome.actions if outcome is not None else {}
        path = results.write_results(report, failures, self.output, sent)
        scores.print(f"results: {path}", markup=False, highlight=False, soft_wrap=True)
        self.unfinished = ""
        cancelled = report.run.state == evaluation_pb2.RUN_STATE_CANCELLED
        if cancelled:
            self.say(f"run {report.run.run_id} was cancelled: its unfinished episodes were given up")
        if self.recording is not None and self.recording.error is not None:
            self.say(f"error: {self.recording.error}; scores and results are not affected")
        elif self.recording is not None:
            scores.print(f"recording: {self.recording.index}", markup=False, highlight=False, soft_wrap=True)
        if not failures:
            recorded = self.recording is None or self.recording.error is None
            return SUCCESS if recorded and not cancelled else ERROR
        given_up = len({episode_id for failure in failures for episode_id in failure.episode_ids})
        self.say(f"\nthe agent failed {len(failures)} time(s); {given_up} episode(s) were given up. First failure:")
        self.say(failures[0].details or failures[0].message)
        others = Counter(failure.message for failure in failures[1:])
        for message, count in others.most_common(5):
            self.say(f"{count} more with: {message}")
        return AGENT_FAILED


def _code(options: argparse.Namespace) -> evaluation_pb2.Code | None:
    """Return where the agent's code is, as the server keeps it; None if no option names it."""
    code = evaluation_pb2.Code(url=options.code_url, commit=options.code_commit.lower(), image=options.code_image)
    return code if code != evaluation_pb2.Code() else None


def _typed(arguments: Mapping[str, str]) -> str:
    return " ".join(f"--agent-arg {shlex.quote(f'{name}={value}')}" for name, value in sorted(arguments.items()))


def agent_name(agent: Agent, spec: str) -> str:
    """Return the agent's attribute `name`, or else the name given on the command line."""
    name = getattr(agent, "name", None)
    return name if isinstance(name, str) and name else spec.removesuffix(":Agent")
