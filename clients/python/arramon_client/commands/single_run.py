"""One run of the main command: create or resume it, play it, show its scores, and write its files."""

import argparse
import shlex
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from arramon.v1 import evaluation_pb2
from arramon_client import dry_run, receipts, results, run_settings
from arramon_client.agent import Agent
from arramon_client.commands.base import ERROR, SUCCESS
from arramon_client.errors import AgentError, ArramonClientError, OutputError, ReceiptError, UsageError
from arramon_client.multi_stream import play_streams
from arramon_client.output import console, episodes_text
from arramon_client.play import Outcome, Settings
from arramon_client.plugin import agent_calls
from arramon_client.plugin.agent_files import agent_label
from arramon_client.plugin.arguments import recorded_arguments
from arramon_client.progress import progress_display
from arramon_client.recording.recorder import Recording
from arramon_client.settings import RETRIES
from arramon_client.transport.connection import Server, call
from arramon_client.transport.incoming import check_same_run
from arramon_client.transport.retry import PATIENCE, Retry, call_until_answered

AGENT_FAILED = 3
"""Exit status: the agent failed in some episodes."""

AGENT_STOPPED = 4
"""Exit status: the agent stopped the run in order, which can be resumed."""

WARNINGS = 5
"""Maximum number of warnings about episodes that differ from the receipt."""


@dataclass(frozen=True)
class FinishedRun:
    """A run that was played to its end.

    Attributes:
        report: its scores.
        outcome: the part played by this client; None if the run had ended before.
        status: the exit status for this run.
        files: paths of its files by kind: "results", and "receipt" and "recording" if they exist.
        agent_report: what the agent's method `run_report` returned; empty without one.
    """

    report: evaluation_pb2.Report
    outcome: Outcome | None
    status: int
    files: Mapping[str, str]
    agent_report: Mapping[str, Any]

    def as_json(self) -> dict[str, Any]:
        """Return the run as plain data: the content of its results file without the actions, and its files."""
        failures = self.outcome.failures if self.outcome is not None else ()
        return {**results.results(self.report, failures, self.agent_report), "files": dict(self.files)}


@dataclass
class SingleRun:
    """One run in one language.

    Attributes:
        options: the command's options.
        language: language of the instructions.
        server: the connected server.
        agent: the agent.
        copies: copies of the agent that can be called at the same time, or none.
        output: the folder for results.
        say: prints a line for the participant.
        revive: called before each attempt to reconnect.
    """

    options: argparse.Namespace
    language: str
    server: Server
    agent: Agent
    copies: Sequence[Agent]
    output: Path
    say: Callable[[str], None]
    revive: Callable[[], None]

    def create(self) -> evaluation_pb2.Run:
        """Create the run, or a dry run with its settings.

        Raises:
            UsageError: if the server does not have what the options name.
            ArramonClientError: if the server refuses.
        """
        options, info = self.options, self.server.info
        split = run_settings.choose_split(info, self.language, options.split, options.languages)
        if options.episode and split.hidden:
            raise UsageError(
                f"split {split.name!r} is hidden and must be played whole; --episode requires an open split"
            )
        sensors = run_settings.choose_sensors(self.agent, options.sensors, split)
        name = agent_name(self.agent, options.agent)
        episodes, named = options.episodes or 0, options.episode
        if options.dry_run:
            name = dry_run.dry_run_name(name)
            split = dry_run.choose_dry_run_split(info, split, self.language, sensors)
            few = min(dry_run.EPISODES, split.episodes[self.language], options.episodes or dry_run.EPISODES)
            episodes, named = (0 if named else few), named[: dry_run.EPISODES]
        request = evaluation_pb2.CreateRunRequest(
            agent=name,
            split=split.name,
            language=self.language,
            sensors=sensors,
            episodes=episodes,
            participant=options.participant,
            episode_ids=named,
            agent_arguments=[
                evaluation_pb2.AgentArgument(name=name, value=typed) for name, typed in self._arguments().items()
            ],
            code=_code(options),
        )
        self._settings()  # Fail before creating a run that could not be played.
        return call(self.server.stub.CreateRun, request, self.server.address)

    def check_resumed(self, run: evaluation_pb2.Run) -> None:
        """Check that a run was started with these options.

        Raises:
            UsageError: if not.
        """
        options = self.options
        for option, requested, kept in (
            ("--agent", agent_name(self.agent, options.agent), run.agent),
            ("--split", options.split, run.split),
            ("--sensors", options.sensors and tuple(sorted(options.sensors)), tuple(sorted(run.sensors))),
        ):
            if requested is not None and requested != kept:
                raise UsageError(f"run {run.run_id} was started with {option} {kept}, not {requested}")
        code = _code(options)
        if code is not None and code != run.code:
            raise UsageError(f"run {run.run_id} was started with other code than --code-url and the like name")
        kept_arguments = {argument.name: argument.value for argument in run.agent_arguments}
        arguments = self._arguments()
        if arguments != kept_arguments:
            begun, requested = (_typed(each) or "no --agent-arg" for each in (kept_arguments, arguments))
            raise UsageError(f"run {run.run_id} was started with {begun}, not with {requested}")

    def finish(self, run: evaluation_pb2.Run) -> FinishedRun:
        """Play a run to its end, show its scores and write its files.

        Raises:
            ArramonClientError: any error whose message is for the participant.
        """
        recording: Recording | None = None
        outcome: Outcome | None = None
        with ExitStack() as stack:
            if self.options.dry_run:
                stack.enter_context(dry_run.cancelled_unless_played(self.server, run.run_id))
            if run.state == evaluation_pb2.RUN_STATE_RUNNING:
                with self._recording(run) as recording:
                    outcome = self._play(run, recording)
            request = evaluation_pb2.GetReportRequest(run_id=run.run_id)
            retry = Retry(run.run_id, PATIENCE, self.say)
            report = call_until_answered(self.server.stub.GetReport, request, self.server.address, retry, self.revive)
            check_same_run(report.run, run.run_id)
            receipt = self._receipt(run.run_id, retry)
        failures = outcome.failures if outcome is not None else ()
        sent = outcome.actions if outcome is not None else {}
        agent_report = self._agent_report() if outcome is not None else {}
        files = {"results": str(results.write_results(report, failures, self.output, sent, agent_report))}
        self._show(report, files)
        status = self._say_what_failed(report, outcome, recording)
        if recording is not None and recording.error is None:
            files["recording"] = self._print("recording", recording.index)
        kept = self._keep(receipt, run.run_id, outcome) if receipt is not None else None
        if kept is not None:
            files["receipt"] = self._print("receipt", kept)
        return FinishedRun(report, outcome, status, files, agent_report)

    def _arguments(self) -> dict[str, str]:
        return recorded_arguments(self.agent, self.options.agent_arguments)

    def _agent_report(self) -> Mapping[str, Any]:
        try:
            return agent_calls.run_report(self.agent)
        except AgentError as error:  # The scores are still shown.
            self.say(f"no report of the agent: {error}")
            return {}

    def _say_summary(self) -> None:
        """Print the agent's line on what it has used, also for a run that was stopped."""
        try:
            summary = agent_calls.summary(self.agent)
        except AgentError as error:  # It must not hide why the run was stopped.
            self.say(f"no summary of the agent: {error}")
            return
        if summary:
            self.say(summary)

    def _settings(self) -> Settings:
        options, info = self.options, self.server.info
        encoding = run_settings.choose_encoding(info, options.encoding, self.server.address)
        return Settings(
            parallel=run_settings.choose_parallel(info, options.parallel, max(1, len(self.copies))),
            encoding=encoding,
            jpeg_quality=run_settings.choose_jpeg_quality(encoding, options.quality),
            image_size=run_settings.choose_image_size(info, options.image_size),
            resume=bool(options.resume),
            keep_going=options.keep_going or options.dry_run,  # Episodes of a dry run do not count.
            retries=RETRIES if options.retries is None else options.retries,
            on_failure=options.on_failure,
            output=self.output,
        )

    def _play(self, run: evaluation_pb2.Run, recording: Recording | None) -> Outcome:
        settings = self._settings()
        kind = "run" if not self.options.dry_run else "dry run"
        self.say(
            f"{kind} {run.run_id}: {run.agent.removesuffix(dry_run.NAME_SUFFIX)} plays {episodes_text(run.episodes)} "
            f"of {run.split}, {run.language}, {settings.parallel} in parallel"
        )
        started = time.monotonic()
        with progress_display(console(stderr=True), quiet=self.options.quiet) as progress:
            try:
                outcome = play_streams(
                    self.server,
                    run,
                    self.agent,
                    settings,
                    notify=self.say,
                    progress=progress,
                    revive=self.revive,
                    recording=recording,
                    copies=self.copies,
                )
            finally:
                self._say_summary()
            seconds = time.monotonic() - started
        self.say(f"{outcome.steps} steps in {seconds:.1f} s, {outcome.steps / max(seconds, 1e-9):.0f} steps/s")
        return outcome

    def _recording(self, run: evaluation_pb2.Run) -> AbstractContextManager[Recording | None]:
        if self.options.record is None:
            return nullcontext()
        return Recording(self.options.record, run, self.say)

    def _receipt(self, run_id: str, retry: Retry) -> evaluation_pb2.Receipt | None:
        request = evaluation_pb2.GetReceiptRequest(run_id=run_id)
        try:
            return call_until_answered(self.server.stub.GetReceipt, request, self.server.address, retry, self.revive)
        except ArramonClientError as error:  # The scores are still shown.
            self.say(f"no receipt: {error}")
            return None

    def _keep(self, receipt: evaluation_pb2.Receipt, run_id: str, outcome: Outcome | None) -> Path | None:
        """Write the receipt, check it against the server's key and the actions sent, and return the file's path."""
        try:
            path = receipts.write_receipt(receipt, run_id, self.output)
        except ReceiptError as error:
            self.say(f"no receipt: {error}")
            return None
        try:
            kept = receipts.read_receipt(path)
            receipts.check_key(kept, self.server.info.public_key, "the server's key")
        except ReceiptError as error:
            self.say(f"warning: {error}")
        else:
            compared = receipts.compare_actions(kept, outcome.actions if outcome is not None else {})
            for difference in compared.differences[:WARNINGS]:
                self.say(f"warning: {difference}")
            if len(compared.differences) > WARNINGS:
                more = len(compared.differences) - WARNINGS
                self.say(f"warning: {more} more episodes differ; to list them all: arramon-client verify {path}")
        return path

    def _show(self, report: evaluation_pb2.Report, files: Mapping[str, str]) -> None:
        if not self.options.json:
            scores = console(results.TABLE_WIDTH)
            scores.print(results.score_table(report))
            scores.print(report.signature, soft_wrap=True)
        self._print("results", files["results"])

    def _print(self, kind: str, path: object) -> str:
        if not self.options.json:
            console().print(f"{kind}: {path}", soft_wrap=True)
        return str(path)

    def _say_what_failed(
        self, report: evaluation_pb2.Report, outcome: Outcome | None, recording: Recording | None
    ) -> int:
        """Describe failures of the run, the recording and the agent; return the exit status."""
        cancelled = report.run.state == evaluation_pb2.RUN_STATE_CANCELLED
        if cancelled:
            self.say(f"run {report.run.run_id} was cancelled: its unfinished episodes were given up")
        broken: OutputError | None = recording.error if recording is not None else None
        if broken is not None:
            self.say(f"error: {broken}; scores and results are not affected")
        failures = outcome.failures if outcome is not None else ()
        if not failures:
            return ERROR if cancelled or broken is not None else SUCCESS
        given_up = len({episode_id for failure in failures for episode_id in failure.episode_ids})
        self.say(f"\nthe agent failed {len(failures)} time(s); {given_up} episode(s) were given up. First failure:")
        self.say(failures[0].details or failures[0].message)
        others = Counter(failure.message for failure in failures[1:])
        for message, count in others.most_common(5):
            self.say(f"{count} more with: {message}")
        return AGENT_FAILED


def _code(options: argparse.Namespace) -> evaluation_pb2.Code | None:
    """Return the location of the agent's code, as the server records it; None if no option names it."""
    code = evaluation_pb2.Code(url=options.code_url, commit=options.code_commit.lower(), image=options.code_image)
    return code if code != evaluation_pb2.Code() else None


def _typed(arguments: Mapping[str, str]) -> str:
    return " ".join(f"--agent-arg {shlex.quote(f'{name}={value}')}" for name, value in sorted(arguments.items()))


def agent_name(agent: Agent, spec: str) -> str:
    """Return the agent's attribute `name`, or else the name given on the command line."""
    name = getattr(agent, "name", None)
    return name if isinstance(name, str) and name else agent_label(spec)
