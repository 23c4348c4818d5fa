"""The main command: play one run for each language, on a remote or an embedded server, and show the scores."""

import argparse
import contextlib
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from arramon.v1 import evaluation_pb2
from arramon_client import arguments, dry_run, results, run_settings
from arramon_client.agent import Agent
from arramon_client.commands.base import SUCCESS
from arramon_client.commands.single_run import AGENT_FAILED, FinishedRun, SingleRun
from arramon_client.errors import ProtocolError, UsageError
from arramon_client.language_gap import gap_table, gaps
from arramon_client.local.embedded import EmbeddedServer
from arramon_client.local.embedded_play import embedded_for_play
from arramon_client.output import console, print_json
from arramon_client.plugin.agent_process import agent_processes, choose_processes
from arramon_client.plugin.arguments import parse_value
from arramon_client.plugin.async_calls import is_async
from arramon_client.plugin.loader import load_agent
from arramon_client.printable import many_lines
from arramon_client.transport.access import Access, access_of
from arramon_client.transport.connection import Server, connect, raise_unreachable
from arramon_client.transport.retry import PATIENCE, Retry, call_until_answered
from arramon_client.world import PREVIEW_LANGUAGES


@dataclass
class PlayCommand:
    """One invocation of the main command.

    Attributes:
        options: the parsed options.
        argv: the arguments as typed.
        begun: ids of the resumed and created runs.
        expected: expected number of runs, one for each language.
        finished: the runs that were played to their end.
        playing: whether playing has begun, after the resumed runs were checked against the options.
    """

    options: argparse.Namespace
    argv: Sequence[str]
    begun: list[str] = field(default_factory=list)
    expected: int = 1
    finished: list[FinishedRun] = field(default_factory=list)
    playing: bool = False

    def __post_init__(self) -> None:
        self.begun += self.options.resume
        self.expected = max(len(self.options.languages or ()), len(self.begun), 1)
        self._console = console(stderr=True)

    def say(self, text: str) -> None:
        """Print a line for the participant without wrapping, so that commands and paths can be copied."""
        with contextlib.suppress(BrokenPipeError):  # The reader of standard error is gone; the run goes on.
            self._console.print(many_lines(text), soft_wrap=True)

    @property
    def output(self) -> Path:
        """The folder for results; a dry run has a subfolder of its own."""
        folder: Path = self.options.output
        return folder / dry_run.FOLDER if self.options.dry_run else folder

    def hint(self, limit: str = "") -> None:
        """Print the command that resumes the unfinished runs, if there are any.

        Args:
            limit: the agent's argument that held the limit that was reached; empty if none was.
        """
        if self.begun and len(self.finished) < self.expected and not self.options.dry_run:
            kept = "the run is saved" if self.expected == 1 else "the runs are saved"
            command = arguments.resume_command(self.argv, ",".join(self.begun), limit)
            self.say(f"{kept}; resume {'it' if self.expected == 1 else 'them'} with\n  {command}")

    def run(self) -> int:
        """Play the runs, show their scores and write their files; return the exit status.

        Raises:
            ArramonClientError: any error whose message is for the participant.
        """
        with _stdout_for_json() if self.options.json else contextlib.nullcontext():
            status = self._run()
        if self.options.json:
            print_json(self._as_json())
        return status

    def _run(self) -> int:
        options = self.options
        arguments = {name: parse_value(typed) for name, typed in options.agent_arguments.items()}
        agent = load_agent(options.agent, arguments)
        if not is_async(agent) and (options.retries is not None or options.on_failure is not None):
            raise UsageError("--retries and --on-failure apply to an agent whose act is `async`, for one observation")
        processes = self._processes(agent)
        results.check_output(self.output)
        if options.record is not None:
            results.check_output(options.record, "the recording")
        with ExitStack() as stack:
            copies = stack.enter_context(agent_processes(processes, agent, options.agent, arguments))
            revive: Callable[[], None] = lambda: None  # noqa: E731 - replaced if a server is embedded
            address, access, unreachable = options.server, Access(), raise_unreachable
            if address is None:
                embedded = stack.enter_context(self._embedded())
                address, revive = embedded.address, embedded.revive
            else:
                access = access_of(options)
                if options.resume:  # The run's server may be restarting.
                    unreachable = Retry(",".join(options.resume), PATIENCE, self.say).wait_for
            server = stack.enter_context(connect(address, access, unreachable=unreachable))
            status = self._play_all(server, agent, copies, revive)
        if len(self.finished) > 1 and not options.json:
            console(results.TABLE_WIDTH).print(gap_table([each.report for each in self.finished]))
        if options.dry_run:
            failed = "fix the agent before the real run" if status == AGENT_FAILED else "see the errors above"
            verdict = "no errors" if status == SUCCESS else failed
            self.say(f"this was a dry run: {verdict}. Run the same command without --dry-run for the real run")
        return status

    def _processes(self, agent: Agent) -> int:
        """Return the number of processes for the agent.

        Raises:
            UsageError: if the agent cannot be copied, and several are requested.
        """
        options = self.options
        methods = [name for name in ("run_report", "run_summary") if callable(getattr(agent, name, None))]
        if is_async(agent) or methods:
            if (options.agent_processes or 1) > 1:
                why = (
                    f"reports on the whole run ({methods[0]})"
                    if methods
                    else "waits, and plays episodes at once anyway"
                )
                raise UsageError(f"--agent-processes is {options.agent_processes}, but this agent {why}")
            return 1
        episodes = dry_run.EPISODES if options.dry_run else (options.episodes or len(options.episode) or None)
        return choose_processes(agent, options.agent_processes, options.parallel, episodes)

    def _play_all(self, server: Server, agent: Agent, copies: Sequence[Agent], revive: Callable[[], None]) -> int:
        """Play one run after the other; return the worst of their exit statuses."""
        resumed = [self._resumed(server, run_id) for run_id in self.options.resume]
        languages = self._languages(server, resumed)
        self.expected = len(languages)
        singles = [
            SingleRun(self.options, language, server, agent, copies, self.output, self.say, revive)
            for language in languages
        ]
        before = {run.language: run for run in resumed}
        for single in singles:  # Check all runs before playing the first.
            if single.language in before:
                single.check_resumed(before[single.language])
        self.playing = True
        for single in singles:
            run = before.get(single.language)
            if run is None:
                run = single.create()
                self.begun.append(run.run_id)
            self.finished.append(single.finish(run))
        return max(each.status for each in self.finished)

    def _resumed(self, server: Server, run_id: str) -> evaluation_pb2.Run:
        request = evaluation_pb2.GetRunRequest(run_id=run_id)
        retry = Retry(run_id, PATIENCE, self.say)  # The server may become unreachable between two calls.
        run = call_until_answered(server.stub.GetRun, request, server.address, retry)
        if run.run_id != run_id:
            raise ProtocolError(f"the server sent the run {run.run_id!r}, expected {run_id}")
        return run

    def _languages(self, server: Server, resumed: Sequence[evaluation_pb2.Run]) -> tuple[str, ...]:
        """Return the languages to play, resumed runs first, after checking that the split has all of them."""
        requested: tuple[str, ...] = self.options.languages or tuple(run.language for run in resumed)
        splits = dict.fromkeys(run.split for run in resumed)
        if len(splits) > 1:
            raise UsageError(f"the runs to resume are of different splits, {', '.join(splits)}: resume them one by one")
        for run in resumed:
            if run.language not in requested:
                raise UsageError(f"run {run.run_id} was started with --lang {run.language}, not {','.join(requested)}")
            if sum(each.language == run.language for each in resumed) > 1:
                raise UsageError(f"run {run.run_id} is not the only one with the language {run.language!r}")
            self.options.split = self.options.split or run.split  # Further languages are played on the same.
        for language in requested if len(resumed) < len(requested) else ():
            run_settings.choose_split(server.info, language, self.options.split, requested)
        for language in sorted({*requested} & {*PREVIEW_LANGUAGES}):
            self.say(f"the language {language!r} is a preview: no native speaker has reviewed its instructions")
        begun = [run.language for run in resumed]
        return (*(each for each in requested if each in begun), *(each for each in requested if each not in begun))

    def _embedded(self) -> AbstractContextManager[EmbeddedServer]:
        options = self.options
        return embedded_for_play(
            options.data,
            self.say,
            workers=options.workers or 1,
            needs_episodes=not (options.split or options.resume),
            quiet=options.quiet,
        )

    def _as_json(self) -> dict[str, Any]:
        """Return the content of `--json`: the only run, or all runs and the gaps between their languages."""
        runs = [each.as_json() for each in self.finished]
        if len(runs) == 1:
            return runs[0]
        first, *others = (each.report for each in self.finished)
        return {"runs": runs, "gaps": [vars(gap) for other in others for gap in gaps(first, other)]}


@contextlib.contextmanager
def _stdout_for_json() -> Iterator[None]:
    """Redirect what the agent and its libraries print to standard error, until the end of the context."""
    out = sys.stdout
    out.flush()
    kept = os.dup(1)
    try:
        os.dup2(2, 1)
        with contextlib.redirect_stdout(sys.stderr):
            yield
    finally:
        for each in (out, sys.__stdout__):  # Text written to them directly may still be in their buffers.
            if each is not None and not each.closed:
                each.flush()
        os.dup2(kept, 1)
        os.close(kept)
