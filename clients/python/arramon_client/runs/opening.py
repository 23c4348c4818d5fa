"""Creating and resuming runs: the request, the start of the stream, and what is read from the server."""

import json
import threading
import weakref
from collections.abc import Callable
from typing import TypeVar

from arramon.v1 import evaluation_pb2
from arramon_client import receipts, run_settings
from arramon_client.errors import RunClosedError, UsageError
from arramon_client.receipts import Receipt
from arramon_client.runs.connection import Connection
from arramon_client.runs.info import RunInfo, info_of
from arramon_client.runs.listing import listed_runs
from arramon_client.runs.live import LiveRun
from arramon_client.runs.live_episode import LiveEpisode
from arramon_client.runs.option_checks import check_options, check_run_id, check_text
from arramon_client.runs.options import CreateOptions, PlayOptions, ServerOptions
from arramon_client.runs.waiting import Operation
from arramon_client.settings import Settings
from arramon_client.transport.connection import Server, call
from arramon_client.transport.incoming import check_same_run
from arramon_client.transport.retry import PATIENCE, Retry, call_until_answered
from arramon_client.world import DEFAULT_SENSORS

Answer = TypeVar("Answer")

STALL_SECONDS = 10.0
"""Time without a step after which a wait for the next episode is reported."""


class OpenedRun:
    """A run that is being played, with its connection.

    Args:
        connection: the connection, which `close` closes.
        run: the run.
        settings: settings of the stream.
        replays: whether recorded steps are handed out.
    """

    def __init__(
        self, connection: Connection, run: evaluation_pb2.Run, settings: Settings, *, replays: bool = False
    ) -> None:
        self.connection, self.run_id = connection, run.run_id
        was_over = run.state != evaluation_pb2.RUN_STATE_RUNNING
        self.live = LiveRun(run, replays=replays, notify=connection.notify, was_over=was_over)
        self._patience = settings.patience
        self._has_reported_stall = False
        if not was_over:
            self.live.start(connection.server.stub, settings, connection.server.address, connection.revive)
        # Also when the run is forgotten, or at the end of the program: the stream first, as it would reconnect.
        self._close = weakref.finalize(self, _close_all, self.live, connection)

    def run(self) -> evaluation_pb2.Run:
        """Return the run as it is on the server now."""
        stub = self.connection.server.stub
        return self._read(stub.GetRun, evaluation_pb2.GetRunRequest(run_id=self.run_id))

    def next_episode(self) -> Operation[LiveEpisode | None]:
        """Return the next episode; None when the run is over. A wait in which nothing is played is reported once."""
        timer = threading.Timer(STALL_SECONDS, self._report_stall, (self.live.steps,))
        timer.daemon = True
        timer.start()
        try:
            return (yield from self.live.next_episode())
        finally:
            timer.cancel()

    def _report_stall(self, steps: int) -> None:
        ids = self.live.open_ids
        if ids and self.live.steps == steps and not self._has_reported_stall:
            self._has_reported_stall = True
            self.connection.notify(
                f"the next episode is awaited, but no step was taken for {STALL_SECONDS:.0f} s: play or give up the "
                f"open episodes first ({', '.join(ids)}), or open more at once (parallel)"
            )

    def cancel(self) -> evaluation_pb2.Run:
        """Cancel the run, and return it."""
        self._check_open()
        request = evaluation_pb2.CancelRunRequest(run_id=self.run_id)
        return call(self.connection.server.stub.CancelRun, request, self.connection.server.address)

    def report(self) -> evaluation_pb2.Report:
        """Return the run's scores.

        Raises:
            UsageError: if the run is not over.
        """
        self._check_open()
        self._check_over("scores")
        stub = self.connection.server.stub
        return self._read(stub.GetReport, evaluation_pb2.GetReportRequest(run_id=self.run_id))

    def receipt(self) -> Receipt:
        """Return the run's receipt, after verifying its signature and the server's key.

        Raises:
            UsageError: if the run is not over.
            ReceiptError: if it was altered, or signed with another key than the server's.
        """
        self._check_open()
        self._check_over("a receipt")
        server = self.connection.server
        message = self._read(server.stub.GetReceipt, evaluation_pb2.GetReceiptRequest(run_id=self.run_id))
        receipt = receipts.receipt_of(message, self.run_id)
        receipts.check_key(receipt, server.info.public_key, "the server's key")
        return receipt

    def close(self) -> None:
        """Close the streams and the connection; the run stays as it is on the server."""
        self._close()

    def _check_open(self) -> None:
        if not self._close.alive:
            raise RunClosedError(f"run {self.run_id} is closed in this program; it can be resumed")

    def _check_over(self, wanted: str) -> None:
        if not self.live.is_over:
            run = self.run()
            if run.state == evaluation_pb2.RUN_STATE_RUNNING:
                raise UsageError(
                    f"run {self.run_id} has {wanted} when it is over, but only {run.episodes_ended} of its "
                    f"{run.episodes} episodes have ended"
                )

    def _read(self, method: Callable[..., Answer], request: object) -> Answer:
        """Make a read-only call, until the server answers."""
        connection = self.connection
        retry = Retry(self.run_id, self._patience, connection.notify)
        answer = call_until_answered(method, request, connection.server.address, retry, connection.revive)
        run = getattr(answer, "run", answer)
        if isinstance(run, evaluation_pb2.Run):
            check_same_run(run, self.run_id)
        return answer


def _close_all(live: LiveRun, connection: Connection) -> None:
    live.close()
    connection.close()


def create(language: str, agent: str, options: CreateOptions, parallel: int) -> OpenedRun:
    """Create a run, and start to play it.

    Args:
        language: language of the instructions.
        agent: name of the agent.
        options: the other options.
        parallel: the default of the option `parallel`.

    Raises:
        UsageError: if an option is wrong, or the server does not have what it names.
        ArramonClientError: if the server cannot be reached or started, or refuses.
    """
    check_options(options, CreateOptions)
    check_text("language", language)
    check_text("agent", agent)
    connection = Connection(options, needs_episodes=not options.get("split"))
    try:
        server = connection.server
        request = _request(server, language, agent, options)
        settings = _settings(server, options, parallel, resumes=False)  # Fail before a run is created.
        run = call(server.stub.CreateRun, request, server.address)
        return OpenedRun(connection, run, settings)
    except BaseException:
        connection.close()
        raise


def resume(run_id: str, options: PlayOptions, parallel: int, *, history: bool) -> OpenedRun:
    """Resume a run, and start to play it.

    Args:
        run_id: id of the run.
        options: server and settings.
        parallel: the default of the option `parallel`.
        history: whether recorded steps are handed out.

    Raises:
        ArramonClientError: as for `create`; also if there is no such run.
    """
    check_options(options, PlayOptions)
    check_run_id(run_id)
    patience = options.get("patience", PATIENCE)
    connection = Connection(options, resumes=run_id, patience=patience)
    try:
        server = connection.server
        retry = Retry(run_id, patience, connection.notify)
        run = call_until_answered(
            server.stub.GetRun, evaluation_pb2.GetRunRequest(run_id=run_id), server.address, retry, connection.revive
        )
        check_same_run(run, run_id)
        return OpenedRun(connection, run, _settings(server, options, parallel, resumes=True), replays=history)
    except BaseException:
        connection.close()
        raise


def _request(server: Server, language: str, agent: str, options: CreateOptions) -> evaluation_pb2.CreateRunRequest:
    split = run_settings.choose_split(server.info, language, options.get("split"))
    code = options.get("code")
    return evaluation_pb2.CreateRunRequest(
        agent=agent,
        split=split.name,
        language=language,
        sensors=run_settings.check_sensors(options.get("sensors", DEFAULT_SENSORS), split),
        episodes=options.get("episodes", 0),
        episode_ids=options.get("episode_ids", ()),
        participant=options.get("participant", ""),
        agent_arguments=[
            # As typed for `--agent-arg`: True is `true`, None is `null`.
            evaluation_pb2.AgentArgument(name=name, value=value if isinstance(value, str) else _json(name, value))
            for name, value in options.get("agent_arguments", {}).items()
        ],
        code=None if not code else evaluation_pb2.Code(**code),
    )


def _json(name: str, value: object) -> str:
    try:
        return json.dumps(value, ensure_ascii=False)
    except (TypeError, ValueError, RecursionError) as error:
        raise UsageError(f"the agent's argument {name} is neither text nor a JSON value: {error}") from error


def _settings(server: Server, options: PlayOptions, parallel: int, *, resumes: bool) -> Settings:
    chosen = run_settings.choose_encoding(server.info, options.get("encoding"), server.address)
    parallel = min(parallel, server.info.max_episodes_per_stream or parallel)
    return Settings(
        parallel=run_settings.choose_parallel(server.info, options.get("parallel") or parallel),
        encoding=chosen,
        jpeg_quality=run_settings.choose_jpeg_quality(chosen, options.get("jpeg_quality")),
        image_size=run_settings.choose_image_size(server.info, options.get("image_size")),
        resume=resumes,
        patience=options.get("patience", PATIENCE),
    )


def list_runs(options: ServerOptions) -> list[RunInfo]:
    """Return the runs that the caller may see, latest first; errors as for `create`."""
    check_options(options, ServerOptions)
    connection = Connection(options)
    try:
        return [info_of(run) for run in listed_runs(connection.server)]
    finally:
        connection.close()
