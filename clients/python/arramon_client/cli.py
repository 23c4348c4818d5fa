"""The command `arramon-client`: plays a run with an agent, and shows its scores; `COMMANDS` has what else it does."""

import argparse
import os
import sys
import time
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass

from rich.console import Console

from arramon.v1 import evaluation_pb2
from arramon_client import account, arguments, choices, leaderboard, receipts, results, verify
from arramon_client.access import Access, access_of
from arramon_client.agent import Agent
from arramon_client.commands import ERROR, FINE, INTERRUPTED, USAGE
from arramon_client.connection import Server, call, connect, give_up
from arramon_client.embedded import EmbeddedServer, default_data, embedded_server
from arramon_client.errors import AgentLoadError, ArramonClientError, ReceiptError, UsageError
from arramon_client.lanes import play_in_lanes
from arramon_client.loading import load_agent
from arramon_client.making import SPLIT, holds_episodes, make_episodes
from arramon_client.play import Outcome, Settings
from arramon_client.progress import shown
from arramon_client.retry import PATIENCE, Retry, ask

AGENT_FAILED = 3

COMMANDS = {
    "account": account.main,
    "leaderboard": leaderboard.show,
    "publish": leaderboard.publish,
    "verify": verify.main,
    "withdraw": leaderboard.withdraw,
}
"""What the client does where its first argument is one of these words: each is given the arguments behind it."""


def main(argv: Sequence[str] | None = None) -> int:
    """Runs the command and returns its exit status: 0 fine, 1 error, 2 usage, 3 the agent failed, 130 interrupted."""
    argv = sys.argv[1:] if argv is None else argv
    os.environ.setdefault("GRPC_VERBOSITY", "NONE")  # What it would write by itself is explained with the error.
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
        if isinstance(error, AgentLoadError) and error.details:
            client.say(error.details)
        client.hint()
        return USAGE if isinstance(error, UsageError | AgentLoadError) else ERROR


@dataclass
class _Client:
    """One invocation.

    Attributes:
        options: as parsed.
        argv: as given.
        console: for everything but the scores.
        unfinished: the run to resume, once there is one and until it is complete.
    """

    options: argparse.Namespace
    argv: Sequence[str]
    console: Console
    unfinished: str = ""

    def say(self, text: str) -> None:
        """Writes a line for the participant, as it is: a command or a path must not be wrapped."""
        self.console.print(text, markup=False, highlight=False, soft_wrap=True)

    def hint(self) -> None:
        """Says how to go on with an unfinished run."""
        if self.unfinished:
            self.say(f"the run is kept; go on with it by\n  {arguments.resume_command(self.argv, self.unfinished)}")

    def run(self) -> int:
        """Does the work.

        Raises:
            ArramonClientError: whatever is wrong.
        """
        options = self.options
        agent = load_agent(options.agent)
        results.check_output(options.output)
        with ExitStack() as stack:
            revive: Callable[[], None] = lambda: None  # noqa: E731 - a default for what an embedded server replaces
            address, access, unreachable = options.server, Access(), give_up
            if address is None:
                embedded = stack.enter_context(self._embedded())
                address, revive = embedded.address, embedded.revive
            else:
                access = access_of(options)
                if options.resume:  # There was a server for this run: it may be starting again.
                    unreachable = Retry(options.resume, PATIENCE, self.say).wait_for
            server = stack.enter_context(connect(address, access, unreachable=unreachable))
            run = self._resumed(server, agent) if options.resume else self._created(server, agent)
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
        return status

    def _embedded(self) -> AbstractContextManager[EmbeddedServer]:
        # Nobody else relies on this server: a step need not outlive a loss of power, only the end of the process.
        # And there is no clock: an agent in a debugger must not lose.
        forever = ("--step-seconds", "0", "--idle-seconds", "0")
        options = ("--no-fsync", "--workers", str(self.options.workers or 1), *forever)
        data = self.options.data or default_data()
        if not (self.options.split or self.options.resume or holds_episodes(data)):
            self.say(f"there are no episodes in {data} yet: making a small part of {SPLIT}, once")
            make_episodes(data, quiet=self.options.quiet)
        return embedded_server(data, options=options, notify=self.say)

    def _created(self, server: Server, agent: Agent) -> evaluation_pb2.Run:
        options = self.options
        split = choices.choose_split(server.info, options.lang, options.split)
        request = evaluation_pb2.CreateRunRequest(
            agent=agent_name(agent, options.agent),
            split=split.name,
            language=options.lang,
            sensors=choices.choose_sensors(agent, options.sensors, split),
            episodes=options.episodes or 0,
            participant=options.participant,
        )
        self._settings(server)  # Before a run is made that could not be played.
        return call(server.stub.CreateRun, request, server.address)

    def _resumed(self, server: Server, agent: Agent) -> evaluation_pb2.Run:
        options = self.options
        request = evaluation_pb2.GetRunRequest(run_id=options.resume)
        retry = Retry(options.resume, PATIENCE, self.say)  # It may go away again between two calls.
        run = ask(server.stub.GetRun, request, server.address, retry)
        for option, asked, kept in (
            ("--agent", agent_name(agent, options.agent), run.agent),
            ("--lang", options.lang, run.language),
            ("--split", options.split, run.split),
            ("--sensors", options.sensors and tuple(sorted(options.sensors)), tuple(sorted(run.sensors))),
        ):
            if asked is not None and asked != kept:
                raise UsageError(f"run {run.run_id} was begun with {option} {kept}, not {asked}")
        return run

    def _settings(self, server: Server) -> Settings:
        encoding = choices.choose_encoding(server.info, self.options.encoding, server.address)
        return Settings(
            parallel=choices.choose_parallel(server.info, self.options.parallel),
            encoding=encoding,
            jpeg_quality=choices.choose_jpeg_quality(encoding, self.options.quality),
            image_size=choices.choose_image_size(server.info, self.options.image_size),
            resume=self.options.resume is not None,
        )

    def _play(self, server: Server, run: evaluation_pb2.Run, agent: Agent, revive: Callable[[], None]) -> Outcome:
        settings = self._settings(server)
        self.unfinished = run.run_id
        self.say(
            f"run {run.run_id}: {run.agent} plays {run.episodes} episodes of {run.split}, {run.language}, "
            f"{settings.parallel} at once"
        )
        started = time.monotonic()
        with shown(self.console, quiet=self.options.quiet) as progress:
            outcome = play_in_lanes(
                server,
                run,
                agent,
                settings,
                notify=self.say,
                progress=progress,
                revive=revive,
            )
        seconds = time.monotonic() - started
        self.say(f"{outcome.steps} steps in {seconds:.1f} s, {outcome.steps / max(seconds, 1e-9):.0f} steps/s")
        return outcome

    def _receipt(
        self, server: Server, run_id: str, retry: Retry, revive: Callable[[], None]
    ) -> evaluation_pb2.Receipt | None:
        request = evaluation_pb2.GetReceiptRequest(run_id=run_id)
        try:
            return ask(server.stub.GetReceipt, request, server.address, retry, revive)
        except ArramonClientError as error:  # The scores are worth showing all the same.
            self.say(f"there is no receipt: {error}")
            return None

    def _keep(self, receipt: evaluation_pb2.Receipt, run_id: str, key: bytes, outcome: Outcome | None) -> None:
        """Keeps a receipt, and checks it while the server's key is known and what was sent is at hand."""
        path = receipts.write_receipt(receipt, run_id, self.options.output)
        try:
            kept = receipts.read_receipt(path)
            receipts.check_key(kept, key, "the server's key")
            receipts.check_actions(kept, outcome.actions if outcome is not None else {})
        except ReceiptError as error:
            self.say(f"warning: {error}")
        Console().print(f"receipt: {path}", markup=False, highlight=False, soft_wrap=True)

    def _show(self, report: evaluation_pb2.Report, outcome: Outcome | None) -> int:
        failures = outcome.failures if outcome is not None else ()
        scores = Console()
        scores.width = max(scores.width, results.TABLE_WIDTH)
        scores.print(results.score_table(report))
        scores.print(report.signature, markup=False, highlight=False, soft_wrap=True)
        sent = outcome.actions if outcome is not None else {}
        path = results.write_results(report, failures, self.options.output, sent)
        scores.print(f"results: {path}", markup=False, highlight=False, soft_wrap=True)
        self.unfinished = ""
        if not failures:
            return FINE
        given_up = len({episode_id for failure in failures for episode_id in failure.episode_ids})
        self.say(f"\nthe agent failed {len(failures)} time(s); {given_up} episode(s) were given up. The first time:")
        self.say(failures[0].details or failures[0].message)
        others = Counter(failure.message for failure in failures[1:])
        for message, count in others.most_common(5):
            self.say(f"{count} more: {message}")
        return AGENT_FAILED


def agent_name(agent: Agent, spec: str) -> str:
    """The agent's own name, or what it was called on the command line."""
    name = getattr(agent, "name", None)
    return name if isinstance(name, str) and name else spec.removesuffix(":Agent")
